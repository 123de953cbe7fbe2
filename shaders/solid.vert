#version 330
// Triangles of the 3-D view.
//
// in   point, normal     mm, in a frame of their own
//      clip_from_local  to clip space
// out  facing            the normal, in that frame

uniform mat4 clip_from_local;
in vec3 point;
in vec3 normal;
out vec3 facing;
out vec3 place;

void main() {
    facing = normal;
    place = point;
    gl_Position = clip_from_local * vec4(point, 1.0);
}
