#version 330
// One colour.
//
// in   tint  colour of the screen, and opacity

uniform vec4 tint;
out vec4 colour;

void main() {
    colour = tint;
}
