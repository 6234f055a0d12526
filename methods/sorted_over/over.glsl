// The first source is added, the second multiplies what is there, channel by channel.
void gather(Fragment fragment) {
    color = vec4(fragment.coverage * fragment.radiance, 1.0);
    color_factor = vec4(transmittance(fragment), 0.0);
}
