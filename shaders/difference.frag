#version 330
// The difference of two pictures, pixel by pixel.
//
// in   picture, other   linear radiance, relative, RGB, of the same size; the first row first
//      gain             1 / the difference that is shown as white
// out  |picture − other| · gain of each channel, as sRGB in [0, 1]

uniform sampler2D picture;
uniform sampler2D other;
uniform float gain;

in vec2 place;
out vec4 colour;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 apart = abs(texelFetch(picture, pixel, 0).rgb - texelFetch(other, pixel, 0).rgb);
    vec3 x = clamp(apart * gain, 0.0, 1.0);
    colour = vec4(mix(1.055 * pow(max(x, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, 12.92 * x,
                      lessThanEqual(x, vec3(0.0031308))), 1.0);
}
