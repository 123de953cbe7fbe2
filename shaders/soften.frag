#version 330
// Hide the noise of the first passes where the lens blurs anyway.
//
// in   picture   linear radiance, relative, RGB, and in alpha how far what is seen lies before the film, mm; the
//                picture's first row first
//      share     radius of the softening per pixel of the circle of confusion's diameter; fades to 0 with the samples
// out  the same, softened
//
// One texel holds both colour and distance: where a processor draws, fetching them is what takes the time.

const int TAPS = 6;
const float LARGEST = 6.0;              // pixels
const float GOLDEN = 2.39996323;        // radians

uniform sampler2D picture;
uniform float coc_gain;                 // pixels · mm:  CoC = coc_gain |1/(distance − coc_offset) − coc_focus|
uniform float coc_focus;                // 1/mm
uniform float coc_offset;               // mm
uniform float coc_power;                // 1/mm, of the lens; with coc_leans and coc_curve for a film out of line, as in develop.frag
uniform vec3 coc_leans;
uniform vec4 coc_curve;
uniform float share;

out vec4 light;

// The radius of the softening where what is seen is so far away; nearer than 1 mm counts as 1 mm.
float reach(float distance, ivec2 at) {
    float nearness = 1.0 / max(distance - coc_offset, 1.0);
    vec2 part = (vec2(at) + 0.5) / vec2(textureSize(picture, 0)), film = (part - 0.5) * coc_curve.yz;
    float r2 = dot(film, film), c = coc_curve.x;
    float lean = dot(coc_leans, vec3(1.0, part)) + coc_curve.w * c * r2 / (1.0 + sqrt(max(1.0 - c * c * r2, 0.0)));
    return min(share * coc_gain * abs(nearness - coc_focus - lean * (coc_power - nearness)), LARGEST);
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
