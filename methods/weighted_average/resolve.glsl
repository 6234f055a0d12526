// n layers of mean opacity and mean color.
void resolve() {
    vec4 total = read_sum();
    float n = max(read_number(), 1.0);
    float covered = 1.0 - pow(max(1.0 - total.a / n, 0.0), n);
    color = vec4(total.rgb * (total.a > 1e-4 ? covered / total.a : 1.0), covered);
}
