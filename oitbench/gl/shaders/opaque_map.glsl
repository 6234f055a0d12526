// The depth of opaque surfaces, as a light sees them.
void gather(Fragment fragment) {}
