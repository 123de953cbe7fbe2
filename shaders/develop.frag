#version 330
// Develop the picture: exposure, tone curve, sRGB, and what is laid over it.
//
// in   picture   linear radiance, relative, RGB, and in alpha how far what is seen lies before the film, mm; the
//                picture's first row first
//      gain      2^exposure
//      headroom  of a picture that a sensor recorded (SENSOR), whose values end at 1: stops from there to the curve's white
// out  sRGB in [0, 1]
//
// app/state/tone.py has the constants of the curves, with their meaning; they are inserted after #version, and so are
// blur.frag, TONE, OVERLAY and SENSOR: software renderers compute both sides of every branch, so that a program holds
// only what it shows.

#define FILMIC 1
#define AGX 2
#define RAW 3
#define COC 1
#define PEAKING 2
#define CLIPPING 3
#define PLANE 4

const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);

uniform float gain;
uniform float headroom;
uniform float sharp;                    // diameter in pixels below which a thing counts as in focus
uniform float stripe;                   // width of a zebra stripe, pixels of the picture
uniform vec3 amber, nearer, farther;    // colours of what is in focus, before and behind it, sRGB

out vec4 colour;

vec3 hable(vec3 x) {
    return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F;
}

vec3 mixed(vec3 rgb, float part) {
    return (1.0 - part) * rgb + part * vec3((rgb.r + rgb.g + rgb.b) / 3.0);
}

vec3 sigmoid(vec3 t) {
    vec3 scale = mix(vec3(SHOULDER), vec3(TOE), lessThan(t, vec3(PIVOT_IN)));
    vec3 x = SLOPE * abs(t - PIVOT_IN) / scale;
    return PIVOT_OUT + sign(t - PIVOT_IN) * scale * x / pow(1.0 + pow(x, vec3(POWER)), vec3(1.0 / POWER));
}

vec3 agx(vec3 rgb) {
    vec3 stops = log2(max(mixed(rgb, INSET), vec3(1e-10))) - log2(GREY);
    vec3 t = clamp((stops + STOPS_BELOW) / (STOPS_BELOW + STOPS_ABOVE), 0.0, 1.0);
    return mixed(pow(max(sigmoid(t), vec3(0.0)), vec3(DISPLAY_GAMMA)), -INSET / (1.0 - INSET));
}

// The power 5/12 as a polynomial of the fourth root, within 0.011 / 255: a processor that draws has no power of its own.
vec3 srgb(vec3 x) {
    vec3 root = sqrt(sqrt(max(x, vec3(0.0031308))));
    vec3 curve = root * (root * (root * (0.0788558 * root - 0.3293719) + 1.1173470) + 0.1980408) - 0.0648438;
    return mix(curve, 12.92 * x, lessThanEqual(x, vec3(0.0031308)));
}

vec3 developed(ivec2 at) {
    at = clamp(at, ivec2(0), textureSize(picture, 0) - 1);
    vec3 rgb = max(texelFetch(picture, at, 0).rgb, vec3(0.0));
#if SENSOR
    vec3 bright = clamp((rgb - GREY) / (1.0 - GREY), 0.0, 1.0);
    rgb *= exp2(headroom * bright * bright * bright);
#endif
    rgb = min(rgb * gain, vec3(1e9));
#if TONE == FILMIC
    rgb = hable(GAIN * min(rgb, vec3(WHITE / GAIN))) / hable(vec3(WHITE)).r;
#elif TONE == AGX
    rgb = agx(rgb);
#elif TONE == RAW
    return clamp(texelFetch(picture, at, 0).rgb, 0.0, 1.0);     // codes of the screen already
#endif
    return srgb(clamp(rgb, 0.0, 1.0));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 rgb = developed(pixel);
    float grey = dot(rgb, LUMINANCE);

    // Circle of confusion: colour tells the side, its strength tells the size on a log scale from 1 to 64 pixels.
#if OVERLAY == COC
    float c = circle(texelFetch(picture, pixel, 0).a, pixel);
    float strength = clamp(log2(max(abs(c), 1.0)) / 6.0, 0.0, 1.0);
    vec3 side = c < 0.0 ? nearer : farther;
    vec3 veil = abs(c) < sharp ? amber : mix(vec3(0.5), side, 0.25 + 0.75 * strength);
    rgb = veil * (0.35 + 0.65 * grey) * (abs(c) < sharp ? 1.0 : 0.55 + 0.45 * strength);
#endif

    // Focus peaking: edges of what is in focus, in amber.
#if OVERLAY == PEAKING
    float right = dot(developed(pixel + ivec2(1, 0)), LUMINANCE);
    float left = dot(developed(pixel - ivec2(1, 0)), LUMINANCE);
    float below = dot(developed(pixel + ivec2(0, 1)), LUMINANCE);
    float above = dot(developed(pixel - ivec2(0, 1)), LUMINANCE);
    float edge = length(vec2(right - left, below - above));
    float focused = 1.0 - smoothstep(0.5 * sharp, sharp, abs(circle(texelFetch(picture, pixel, 0).a, pixel)));
    rgb = mix(mix(rgb, vec3(grey), 0.6), amber, focused * smoothstep(0.06, 0.16, edge));
#endif

    // Plane of focus: a sheet of amber through the scene. What lies behind it is seen through it; it is denser over what
    // counts as sharp, up to a line at either limit, and ends in a strong line where it cuts things.
#if OVERLAY == PLANE
    float from = circle(texelFetch(picture, pixel, 0).a, pixel);
    float step = min(1.5 * fwidth(from), 0.5 * sharp);
    float cover = abs(from) < sharp ? 0.45 : from > 0.0 ? 0.18 : 0.0;
    rgb = mix(rgb, amber, cover);
    rgb = abs(abs(from) - sharp) < step ? mix(rgb, from < 0.0 ? nearer : farther, 0.9) : rgb;
    rgb = abs(from) < step ? mix(amber, vec3(1.0), 0.45) : rgb;
#endif

    // Clipping: stripes where a channel has no more to give, leaning right for white and left for black.
#if OVERLAY == CLIPPING
    vec2 at = gl_FragCoord.xy / stripe;
    bool white = max(rgb.r, max(rgb.g, rgb.b)) > 0.996;
    bool black = max(rgb.r, max(rgb.g, rgb.b)) < 0.012;
    if (white && mod(at.x + at.y, 2.0) < 1.0)
        rgb = vec3(0.84, 0.37, 0.0);
    if (black && mod(at.x - at.y, 2.0) < 1.0)
        rgb = vec3(0.0, 0.45, 0.70);
#endif
    colour = vec4(rgb, 1.0);
}
