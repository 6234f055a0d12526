// The frame's projection and size, in every shader; filled by oitbench/gl/view.py.
layout(std140, binding = 0) uniform View {
    mat4 world_to_clip;
    mat4 world_to_camera;
    float near_plane;      // m
    float far_plane;       // m, may be infinite
    float pixel_focal;     // focal length in pixels
    float radiance_gain;   // 1, or 0 to see only transmittance
    uvec2 frame_size;      // pixels
    uvec2 frame_tiles;     // tiles of TILE x TILE pixels
    uint iteration;        // round of the loop around the pass, from 0
    vec4 eye;              // position and 1, or the direction to the viewer and 0
};

// Linear view distance of a window depth, m; very large for an empty pixel before an infinite plane.
float view_distance(float depth) {
    return near_plane / max(1.0 - depth * (1.0 - near_plane / far_plane), 1e-9);
}

// Direction from the eye through the pixel, in world space, to advance one meter of view distance.
vec3 pixel_ray(vec2 pixel) {
    vec2 slope = (pixel - 0.5 * vec2(frame_size)) / pixel_focal;
    return transpose(mat3(world_to_camera)) * vec3(slope, -1.0);
}

const uint NONE = 0xFFFFFFFFu;
