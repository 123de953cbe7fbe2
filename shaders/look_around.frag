#version 330
// A view from inside a panorama, as a perspective camera at its centre would see it.
//
// in   picture   the developed panorama, sRGB, its first row first
//      layout_kind  0 equirectangular, 1 equal-area, 2 cube map, as in core/cameras/environment.py
//      turn      columns: right, up and back of the view, in the frame of the panorama's camera
//      reach     tangents of half the angle of view, across and down
//      size      of the view, pixels
// out  sRGB in [0, 1], the first row first

const float PI = 3.14159265358979;

uniform sampler2D picture;
uniform int layout_kind;
uniform mat3 turn;
uniform vec2 reach;
uniform vec2 size;

out vec4 colour;

vec2 equirectangular(vec3 d) {
    return vec2(atan(d.x, -d.z) / PI, atan(-d.y, length(d.xz)) * 2.0 / PI);
}

vec2 equal_area(vec3 d) {
    float r = sqrt(max(1.0 - abs(d.z), 0.0));
    float along = (d.x == 0.0 && d.y == 0.0) ? 0.0 : atan(abs(d.y), abs(d.x)) * 2.0 / PI * r;
    float across = r - along;
    vec2 at = d.z <= 0.0 ? vec2(across, along) : vec2(1.0 - along, 1.0 - across);
    return vec2(d.x < 0.0 ? -at.x : at.x, d.y > 0.0 ? -at.y : at.y);
}

vec2 cube_map(vec3 d) {
    vec3 size_of = abs(d);
    float greatest = max(size_of.x, max(size_of.y, size_of.z));
    bool level = max(size_of.x, size_of.z) >= size_of.y;
    bool ahead = size_of.z >= size_of.x;
    float k = !level ? 0.0 : ahead ? (d.z <= 0.0 ? 0.0 : 2.0) : sign(d.x);
    float a = !level ? d.x : ahead ? (d.z <= 0.0 ? d.x : -d.x) : sign(d.x) * d.z;
    float rise = level ? 0.0 : sign(d.y);
    float b = level ? -d.y : -rise * d.z;
    return vec2((k + 0.5 * (1.0 + a / greatest) - 1.0) / 2.0, (0.5 * (1.0 + b / greatest) - rise - 0.5) / 1.5);
}

void main() {
    vec2 at = 2.0 * gl_FragCoord.xy / size - 1.0;           // the first row is the upper one
    vec3 d = normalize(turn * vec3(at.x * reach.x, -at.y * reach.y, -1.0));
    vec2 uv = layout_kind == 0 ? equirectangular(d) : layout_kind == 1 ? equal_area(d) : cube_map(d);
    colour = vec4(textureLod(picture, 0.5 + 0.5 * uv, 0.0).rgb, 1.0);
}
