// The opaque picture: what lies behind all transparency. Seen through transmittance alone it is 1.
void gather(Fragment fragment) {
    color = vec4(radiance_gain > 0.0 ? min(fragment.radiance, 65504.0) : vec3(1.0), 1.0);
}
