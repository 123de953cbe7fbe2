// The circle of confusion of a pixel; inserted into the shaders that need it.
//
// in   picture   in alpha how far what is seen lies before the film, mm; the picture's first row first
//      blur      nodes from the picture's upper left corner to its lower right one, evenly: what is in focus (pixels),
//                the gain (pixels · mm) and the distance of the pupil before the film (mm); see app/plots/blur.py

uniform sampler2D picture;
uniform sampler2D blur;

// In pixels, a diameter, negative for what lies before the focus; nearer than 1 mm before the pupil counts as 1 mm.
float circle(float distance, ivec2 at) {
    vec2 part = (vec2(at) + 0.5) / vec2(textureSize(picture, 0)), nodes = vec2(textureSize(blur, 0));
    vec3 here = texture(blur, (part * (nodes - 1.0) + 0.5) / nodes).rgb;
    return here.x - here.y / max(distance - here.z, 1.0);
}
