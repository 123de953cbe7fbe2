#version 330
// One triangle that covers the target. Gives `place`, (0, 0) in the corner of the picture's first row and column to (1, 1).

out vec2 place;

void main() {
    place = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}
