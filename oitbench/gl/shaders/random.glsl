// Random numbers by hashing integers: no table, no state, the same on every device.

// Jarzynski & Olano 2020, JCGT 9(3), "pcg3d": three words from three.
uvec3 hash(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// The same authors' "pcg": one word from one.
uint hash(uint v) {
    uint state = v * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// Uniform in [0, 1), of 24 bits so that it never rounds up to one.
float unit_interval(uint word) {
    return float(word >> 8u) * (1.0 / 16777216.0);
}
