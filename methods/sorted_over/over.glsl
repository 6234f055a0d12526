// The first source is added, the second multiplies the target, channel by channel.
void gather(Fragment fragment) {
    color = vec4(fragment.coverage * fragment.radiance, 1.0);
    color_factor = vec4(transmittance(fragment), 0.0);
}
