#version 330
// Hide the noise of the first passes where the lens blurs anyway.
//
// in   picture   linear radiance, relative, RGB; the picture's first row first
//      depth     reciprocal distance from the front principal plane, 1/mm; 0 is infinitely far
//      share     radius of the softening per pixel of the circle of confusion's diameter; fades to 0 with the samples
// out  linear radiance

const int TAPS = 6;
const float LARGEST = 6.0;              // pixels
const float GOLDEN = 2.39996323;        // radians

uniform sampler2D picture;
uniform sampler2D depth;
uniform float coc_gain;                 // pixels · mm:  CoC = coc_gain |1/depth − coc_focus|
uniform float coc_focus;                // 1/mm
uniform float share;

out vec3 light;

// The radius of the softening at a pixel.
float reach(ivec2 at) {
    vec2 scale = vec2(textureSize(depth, 0)) / vec2(textureSize(picture, 0));
    float reciprocal = texelFetch(depth, ivec2((vec2(at) + 0.5) * scale), 0).r;
    return min(share * coc_gain * abs(reciprocal - coc_focus), LARGEST);
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(picture, 0) - 1;
    float radius = reach(here);
    vec3 sum = texelFetch(picture, here, 0).rgb;
    float weight = 1.0;
    for (int i = 0; i < TAPS; ++i) {
        float r = radius * sqrt((float(i) + 0.5) / float(TAPS));
        vec2 turn = vec2(cos(GOLDEN * float(i)), sin(GOLDEN * float(i)));
        ivec2 there = clamp(here + ivec2(round(r * turn)), ivec2(0), last);
        // A neighbour in focus must not bleed into what is blurred.
        float w = smoothstep(0.0, 1.0, reach(there) / max(r, 0.5));
        sum += w * texelFetch(picture, there, 0).rgb;
        weight += w;
    }
    light = sum / weight;
}
