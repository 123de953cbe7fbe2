#version 330
// Lines of the 3-D view with a width in pixels: a quadrilateral for each piece.
//
// in   begin, end        mm, in a frame of their own; one pair an instance
//      clip_from_local  to clip space
//      size, width       of the target and of the line, pixels

uniform mat4 clip_from_local;
uniform vec2 size;
uniform float width;
in vec3 begin;
in vec3 end;

void main() {
    vec4 a = clip_from_local * vec4(begin, 1.0);
    vec4 b = clip_from_local * vec4(end, 1.0);
    // Cut what lies behind the eye
    float least = 1e-3 * max(abs(a.w), abs(b.w)) + 1e-6;
    if (a.w < least && b.w < least) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    if (a.w < least) a = mix(a, b, (least - a.w) / (b.w - a.w));
    if (b.w < least) b = mix(b, a, (least - b.w) / (a.w - b.w));
    vec2 along = (b.xy / b.w - a.xy / a.w) * size;
    along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
    vec2 aside = vec2(-along.y, along.x) * width / size;
    vec4 at = (gl_VertexID & 1) == 0 ? a : b;
    float side = (gl_VertexID & 2) == 0 ? 1.0 : -1.0;
    gl_Position = vec4(at.xy + side * aside * at.w, at.z, at.w);
}
