#version 330
// Shading of the 3-D view: a light beside the eye, the same on both sides of a surface.
//
// in   facing, place  normal and point, mm, in the frame of the part
//      eye, light     where the eye is, mm; the direction to the light, a unit vector; in that frame
//      tint           colour of the screen, and opacity
//      rim            how much more opaque a surface is that is seen along itself: glass
// out  the colour of the screen

uniform vec3 eye;
uniform vec3 light;
uniform vec4 tint;
uniform float rim;
in vec3 facing;
in vec3 place;
out vec4 colour;

void main() {
    vec3 normal = normalize(facing + vec3(1e-9));
    float seen = abs(dot(normal, normalize(eye - place)));
    float shade = 0.38 + 0.62 * abs(dot(normal, light));
    float edge = pow(1.0 - seen, 3.0) * rim;
    colour = vec4(tint.rgb * shade + edge * 0.25, clamp(tint.a + edge, 0.0, 1.0));
}
