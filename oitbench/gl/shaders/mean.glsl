// The mean of all frames so far is the picture of each frame.
void resolve() {
    color = read_accumulated() / float(frame_number + 1u);
}
