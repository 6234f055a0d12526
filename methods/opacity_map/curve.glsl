// Slice k of TERMS holds the absorbance up to the relative depth (k + 1) / TERMS.
void deposit(float u, float absorbance) {
    for (int k = 0; k < TERMS; ++k) {
        terms[k] += u * float(TERMS) <= float(k + 1) ? absorbance : 0.0;
    }
}

// Linear between the slices in front and behind; nothing is absorbed at 0.
float absorbed(float u, float own) {
    float place = u * float(TERMS);
    float front = 0.0;
    float behind = terms[0];
    for (int k = 1; k < TERMS; ++k) {
        front = place >= float(k) ? terms[k - 1] : front;
        behind = place >= float(k) ? terms[k] : behind;
    }
    return mix(front, behind, place - min(floor(place), float(TERMS - 1)));
}
