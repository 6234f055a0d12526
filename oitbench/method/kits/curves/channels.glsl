// Which color channels a round serves: all at once by their mean, or the one of the loop's round.
#if CHANNELS == CHANNELS_RGB

vec3 served() { return vec3(equal(uvec3(0u, 1u, 2u), uvec3(iteration))); }
float served_factor(vec3 factor) { return dot(factor, served()); }

#else

vec3 served() { return vec3(1.0); }
float served_factor(vec3 factor) { return (factor.r + factor.g + factor.b) / 3.0; }

#endif

// Factor on the background in all channels: one in channels that the round does not serve.
vec3 background_factor(float total) { return mix(vec3(1.0), vec3(total), served()); }
