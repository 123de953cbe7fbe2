#version 330
// Hide the noise of the first passes where the lens blurs anyway.
//
// in   picture   linear radiance, relative, RGB, and in alpha how far what is seen lies before the film, mm; the
//                picture's first row first
//      share     radius of the softening per pixel of the circle of confusion's diameter; fades to 0 with the samples
// out  the same, softened
//
// blur.frag is inserted after #version.
//
// One texel holds both colour and distance: where a processor draws, fetching them is what takes the time.

const int TAPS = 6;
const float LARGEST = 6.0;              // pixels
const float GOLDEN = 2.39996323;        // radians

uniform float share;

out vec4 light;

// The radius of the softening where what is seen is so far away.
float reach(float distance, ivec2 at) {
    return min(share * abs(circle(distance, at)), LARGEST);
}

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(picture, 0) - 1;
    vec4 middle = texelFetch(picture, here, 0);
    float radius = reach(middle.a, here);
    vec3 sum = middle.rgb;
    float weight = 1.0;
    for (int i = 0; i < TAPS; ++i) {
        float r = radius * sqrt((float(i) + 0.5) / float(TAPS));
        vec2 turn = vec2(cos(GOLDEN * float(i)), sin(GOLDEN * float(i)));
        ivec2 place = clamp(here + ivec2(round(r * turn)), ivec2(0), last);
        vec4 there = texelFetch(picture, place, 0);
        // A neighbour in focus must not bleed into what is blurred.
        float w = smoothstep(0.0, 1.0, reach(there.a, place) / max(r, 0.5));
        sum += w * there.rgb;
        weight += w;
    }
    light = vec4(sum / weight, middle.a);
}
