// The medium that fills a box, and how it dims beams. Filled by oitbench/gl/shading/medium.py.
layout(std140, binding = 2) uniform Medium {
    vec4 medium_low;       // corner of the box, m; extinction where the density is one, 1/m
    vec4 medium_high;      // corner of the box, m; anisotropy g
    vec4 medium_color;     // single-scattering albedo; collimation
    vec4 medium_ambient;   // radiance from all sides that is not a beam
};

#ifdef DENSITY
uniform sampler3D density_texture;   // factor on the extinction, linear between cells' centers
#endif

// Steps in which a varying density dims beams on their way to surfaces.
const int DIMMING_STEPS = 8;

float density_at(vec3 position) {
#ifdef DENSITY
    vec3 place = (position - medium_low.xyz) / (medium_high.xyz - medium_low.xyz);
    return textureLod(density_texture, place, 0.0).r;
#else
    return 1.0;
#endif
}

// Part of light `i` that the medium lets through to `position`: exact for a constant density, else by
// the midpoint rule of `steps` steps.
float passing_medium(int i, vec3 position, int steps) {
    vec3 toward = toward_light(i, position);
    vec3 safe = mix(toward, vec3(1e-12), lessThan(abs(toward), vec3(1e-12)));
    vec3 one = (medium_low.xyz - position) / safe, other = (medium_high.xyz - position) / safe;
    vec3 first = min(one, other), last = max(one, other);
    float enters = max(max(first.x, first.y), max(first.z, 0.0));
    float leaves = min(min(last.x, last.y), last.z);
    if (beams[i].place.w != 0.0) {
        leaves = min(leaves, distance(position, beams[i].place.xyz));
    }
    float meters = max(leaves - enters, 0.0), density = 0.0;
#ifdef DENSITY
    for (int k = 0; k < steps; ++k) {
        float part = (float(k) + 0.5) / float(steps);
        density += density_at(position + (enters + part * meters) * toward) / float(steps);
    }
#else
    density = 1.0;
#endif
    return exp(-medium_low.w * density * meters);
}
