// Normalized moments in [0, 1]: matrices of Muenstermann et al. 2018 that stretch the range of
// possible odd and even moments over the unit cube; trigonometric ones need none.
#if BASIS == BASIS_TRIGONOMETRIC

float[COUNT] to_unit(float[COUNT] b) {
    for (int i = 0; i < COUNT; ++i) {
        b[i] = 0.5 * b[i] + 0.5;
    }
    return b;
}

float[COUNT] from_unit(float[COUNT] q) {
    for (int i = 0; i < COUNT; ++i) {
        q[i] = 2.0 * q[i] - 1.0;
    }
    return q;
}

#else

// Column i holds the factors of the odd or even moment i.
#if COUNT == 4
#define VECTOR vec2
#define MATRIX mat2
const MATRIX ODD = MATRIX(1.5, 0.86602540378, -2.0, -0.38490017946);
const MATRIX EVEN = MATRIX(4.0, 0.5, -4.0, 0.5);
const VECTOR EVEN_OFFSET = VECTOR(0.0);
#elif COUNT == 6
#define VECTOR vec3
#define MATRIX mat3
const MATRIX ODD = MATRIX(2.5, -1.87499864450, 1.26583039016, -10.0, 4.20757543111, -1.47644882902,
                          8.0, -1.83257678661, 0.71061660238);
const MATRIX EVEN = MATRIX(4.0, 9.0, -0.57759806484, -4.0, -24.0, 4.61936647543,
                           0.0, 16.0, -3.07953906655);
const VECTOR EVEN_OFFSET = VECTOR(0.0, 0.0, 0.018888946);
#else
#define VECTOR vec4
#define MATRIX mat4
const MATRIX ODD = MATRIX(
    3.48044635732474, 1.26797185782836, -2.1671560004294, 0.974332879165755,
    -27.5760737514826, -0.928755808743913, 6.17950199592966, -0.443426830933027,
    55.1267384344761, -2.07520453231032, -0.276515571579297, -0.360491648368785,
    -31.5311110403183, 1.23598848322588, -4.23583042392097, 0.310149466050223);
const MATRIX EVEN = MATRIX(
    0.280504133158527, -2.01362265883247, -7.31010494985321, -15.8954215629556,
    -0.757633844606942, 0.221551373038988, 13.9855979699139, 79.6186327084103,
    0.392179589334688, -1.06107954265125, -0.114305766176437, -127.457278992502,
    -0.887531871812237, 2.83887201588367, -7.4361899359832, 63.7349456687829);
const VECTOR EVEN_OFFSET = VECTOR(0.972481993925964, 1.0, 0.999179192513328, 0.991778293073131);
#endif
const VECTOR ODD_OFFSET = VECTOR(0.5);

// Moments come as b1, b2, b3 ...; stored ones first all odd, then all even.
float[COUNT] to_unit(float[COUNT] b) {
    VECTOR odd;
    VECTOR even;
    for (int i = 0; i < HALF; ++i) {
        odd[i] = b[2 * i];
        even[i] = b[2 * i + 1];
    }
    odd = ODD * odd + ODD_OFFSET;
    even = EVEN * even + EVEN_OFFSET;
    for (int i = 0; i < HALF; ++i) {
        b[i] = odd[i];
        b[HALF + i] = even[i];
    }
    return b;
}

float[COUNT] from_unit(float[COUNT] q) {
    VECTOR odd;
    VECTOR even;
    for (int i = 0; i < HALF; ++i) {
        odd[i] = q[i];
        even[i] = q[HALF + i];
    }
    odd = inverse(ODD) * (odd - ODD_OFFSET);
    even = inverse(EVEN) * (even - EVEN_OFFSET);
    for (int i = 0; i < HALF; ++i) {
        q[2 * i] = odd[i];
        q[2 * i + 1] = even[i];
    }
    return q;
}

#endif
