// One opacity for all channels, or one for each where transmission is colored.
#ifdef EFFECT_COLORED_TRANSMISSION
const int CURVES = 3;
#else
const int CURVES = 1;
#endif
