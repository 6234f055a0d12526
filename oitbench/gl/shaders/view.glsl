// The frame's projection and size, in every shader; filled by oitbench/gl/view.py.
layout(std140, binding = 0) uniform View {
    mat4 vertex_to_clip;   // of positions relative to the camera
    mat4 world_to_camera;  // of `fragment.position`
    float near_plane;      // m
    float far_plane;       // m, may be infinite
    float pixel_focal;     // focal length in pixels; pixels per meter if rays are parallel
    float radiance_gain;   // 1, or 0 to see only transmittance
    uvec2 frame_size;      // pixels
    uvec2 frame_tiles;     // tiles of TILE x TILE pixels
    uint iteration;        // round of the loop around the pass, from 0
    uint frame_number;     // of the frames whose mean is the image, from 0
    vec2 view_center;      // where the view axis meets the picture, pixels
    vec4 eye;              // relative position and 1, or, for parallel rays, direction to it and 0
    vec4 origin;           // position of the camera in the world, less whole kilometers, m
    vec2 transparent_range; // least and greatest view distance of all transparent geometry, m
};

// Depth is stored as 1 - d, which is near/z before an infinite far plane and 0 where nothing is: as a
// float it is precise at every distance, which d itself is not. It is linear where rays are parallel.

// Window depth d in [0, 1] of a stored depth.
float window_depth(float inverse_depth) { return 1.0 - inverse_depth; }

// Stored depth of a linear view distance, m.
float inverse_depth_at(float z) {
    if (eye.w == 0.0) {
        return (far_plane - z) / (far_plane - near_plane);
    }
    return (near_plane / z - near_plane / far_plane) / (1.0 - near_plane / far_plane);
}

// Linear view distance of a stored depth, m; very large for an empty pixel before an infinite plane,
// or where rays are parallel.
float view_distance(float inverse_depth) {
    if (eye.w == 0.0) {
        float z = far_plane - inverse_depth * (far_plane - near_plane);
        return inverse_depth > 0.0 ? z : 1e30 * near_plane;
    }
    float ratio = near_plane / far_plane;
    return near_plane / max(mix(inverse_depth, 1.0, ratio), 1e-30 * near_plane);
}

// Length that `pixel_focal` pixels show at the view distance `z`, m.
float shown_at(float z) { return eye.w == 0.0 ? 1.0 : z; }

// Direction of the pixel's ray, in world space, to advance one meter of view distance.
vec3 pixel_ray(vec2 pixel) {
    vec2 slope = eye.w * (pixel - view_center) / pixel_focal;
    return transpose(mat3(world_to_camera)) * vec3(slope, -1.0);
}

// Where the pixel's ray leaves the plane of the eye, relative to the camera of the upload, m.
vec3 pixel_origin(vec2 pixel) {
    if (eye.w != 0.0) {
        return eye.xyz;
    }
    vec3 place = vec3((pixel - view_center) / pixel_focal, 0.0) - world_to_camera[3].xyz;
    return transpose(mat3(world_to_camera)) * place - origin.xyz;
}

const uint NONE = 0xFFFFFFFFu;
