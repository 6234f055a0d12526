// Openness: the fraction of the cosine-weighted hemisphere over a surface that is not occluded, from
// the depth buffer. In each of a few planes through the view ray, the horizon on either side is
// found, and the arc between both horizons is integrated in closed form (Jimenez et al.
// 2016, "Practical realtime strategies for accurate indirect occlusion", equations 3 to 7; horizons:
// Bavoil et al. 2008). The sum over the planes is divided by its value without horizons, so that a
// flat surface is exactly open, however few planes are used.

const float QUARTER = 1.57079632679490;                  // of a turn, radians

// Camera space, m.
vec3 place_of(ivec2 pixel, float depth) {
    float z = view_distance(depth);
    vec2 slope = (vec2(pixel) + 0.5 - 0.5 * vec2(frame_size)) / pixel_focal;
    return vec3(slope * shown_at(z), -z);
}

// The surface's change from pixel to pixel along `axis`, from the side on which it goes on. Depth is
// linear over a plane of the picture, so a side whose next two depths lead here is the same plane.
vec3 change_along(ivec2 pixel, ivec2 axis, float depth) {
    ivec2 last = ivec2(frame_size) - 1;
    ivec2 ahead = min(pixel + axis, last), back = max(pixel - axis, ivec2(0));
    float d1 = read_occluders(ahead), e1 = read_occluders(back);
    float d2 = read_occluders(min(pixel + 2 * axis, last));
    float e2 = read_occluders(max(pixel - 2 * axis, ivec2(0)));
    vec3 here = place_of(pixel, depth);
    bool forward = abs(2.0 * d1 - d2 - depth) < abs(2.0 * e1 - e2 - depth);
    forward = (forward || back == pixel) && ahead != pixel;
    return forward ? place_of(ahead, d1) - here : here - place_of(back, e1);
}

// A plane through the view ray, as the surface that is shaded cuts it.
struct Slice {
    vec3 view;     // unit, toward the eye
    vec3 axis;     // unit, normal to the plane
    vec3 aside;    // along the surface, by one along `axis` and by none across the picture
};

// Cosine between the view and the highest horizon in one direction, no lower than `lowest`. Surfaces
// count fully within half the radius, and fade beyond it.
float horizon(ivec2 pixel, vec3 here, Slice slice, vec2 direction, float reach, float start,
              float lowest) {
    float highest = lowest;
    for (int k = 0; k < STEPS; ++k) {
        float part = (float(k) + start) / float(STEPS);
        // Denser near by; never the pixel itself.
        ivec2 at = pixel + ivec2(round(direction * max(part * part * reach, 1.0)));
        if (at != clamp(at, ivec2(0), ivec2(frame_size) - 1)) {
            break;
        }
        float depth = read_occluders(at);
        if (depth > 0.0) {
            vec3 offset = place_of(at, depth) - here;
            float distance = length(offset);
            float weight = clamp(2.0 - 2.0 * distance / RADIUS, 0.0, 1.0);
            // Pixels lie a little beside the plane; moved into it along the surface, those of the
            // surface stay on it, and it does not hide itself.
            vec3 moved = offset - slice.aside * dot(offset, slice.axis);
            float cosine = dot(moved, slice.view) / max(length(moved), 1e-9);
            highest = max(highest, mix(lowest, cosine, weight));
        }
    }
    return highest;
}

// Cosine-weighted light of a plane between the view ray and a horizon at angle `h`; the normal's
// projection is at angle `n`.
float between(float h, float n) { return 0.25 * (cos(n) - cos(2.0 * h - n) + 2.0 * h * sin(n)); }

void resolve() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = read_occluders();
    if (depth <= 0.0) {
        discard;
    }
    vec3 here = place_of(pixel, depth);
    vec3 view = eye.w == 0.0 ? vec3(0.0, 0.0, 1.0) : normalize(-here);
    vec3 normal = cross(change_along(pixel, ivec2(1, 0), depth),
                        change_along(pixel, ivec2(0, 1), depth));
    normal = normalize(dot(normal, view) < 0.0 ? -normal : normal);
    float reach = RADIUS * pixel_focal / shown_at(-here.z);
    // Each block of 4 x 4 pixels has 16 directions and four first steps; the filter removes the
    // pattern.
    float turn = float((((pixel.x + pixel.y) & 3) << 2) + (pixel.x & 3)) / 16.0;
    float start = (float((pixel.y - pixel.x) & 3) + 0.5) / 4.0;
    float seen = 0.0, all = 0.0;
    for (int k = 0; k < PLANES; ++k) {
        float angle = (float(k) + turn) * 2.0 * QUARTER / float(PLANES);
        vec2 direction = vec2(cos(angle), sin(angle));
        vec3 side = vec3(direction, 0.0);
        vec3 axis = normalize(cross(side, view)), tangent = cross(view, axis);
        vec3 projected = normal - axis * dot(normal, axis);
        float size = length(projected);
        if (size <= 1e-3) {
            continue;
        }
        vec3 aside = axis - view * dot(normal, axis) / max(dot(normal, view), 1e-4);
        Slice slice = Slice(view, axis, aside);
        float n = atan(dot(projected, tangent), dot(projected, view));
        // Angles grow along `direction`; no horizon is below the surface itself.
        float high = acos(clamp(horizon(pixel, here, slice, direction, reach, start,
                                        cos(n + QUARTER)), -1.0, 1.0));
        float low = acos(clamp(horizon(pixel, here, slice, -direction, reach, start,
                                       cos(n - QUARTER)), -1.0, 1.0));
        seen += size * (between(high, n) + between(-low, n));
        all += size * (cos(n) + n * sin(n));
    }
    raw = all > 0.0 ? clamp(seen / all, 0.0, 1.0) : 1.0;
}
