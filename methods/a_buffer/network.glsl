// Sorts the depths of a batch, and the records that they belong to, by Batcher's odd-even merges: a
// fixed network of 191 exchanges, so that compilers keep the batch in registers.
const int BATCH = 32;
float batch_depth[BATCH];
uint batch_node[BATCH];

void exchange(int i, int k) {
    bool swapped = batch_depth[k] < batch_depth[i];
    float depth = batch_depth[i];
    uint node = batch_node[i];
    batch_depth[i] = swapped ? batch_depth[k] : depth;
    batch_node[i] = swapped ? batch_node[k] : node;
    batch_depth[k] = swapped ? depth : batch_depth[k];
    batch_node[k] = swapped ? node : batch_node[k];
}

// MERGE_n merges the two sorted halves of n places, s apart, from place a; SORT_n sorts n places.
#define PAIRS_1(a, s) exchange(a + s, a + 2 * (s));
#define PAIRS_3(a, s) PAIRS_1(a, s) PAIRS_1(a + 2 * (s), s) PAIRS_1(a + 4 * (s), s)
#define PAIRS_7(a, s) PAIRS_3(a, s) PAIRS_1(a + 6 * (s), s) PAIRS_3(a + 8 * (s), s)
#define PAIRS_15(a, s) PAIRS_7(a, s) PAIRS_1(a + 14 * (s), s) PAIRS_7(a + 16 * (s), s)
#define MERGE_2(a, s) exchange(a, a + s);
#define MERGE_4(a, s) MERGE_2(a, 2 * (s)) MERGE_2(a + s, 2 * (s)) PAIRS_1(a, s)
#define MERGE_8(a, s) MERGE_4(a, 2 * (s)) MERGE_4(a + s, 2 * (s)) PAIRS_3(a, s)
#define MERGE_16(a, s) MERGE_8(a, 2 * (s)) MERGE_8(a + s, 2 * (s)) PAIRS_7(a, s)
#define MERGE_32(a, s) MERGE_16(a, 2 * (s)) MERGE_16(a + s, 2 * (s)) PAIRS_15(a, s)
#define SORT_2(a) MERGE_2(a, 1)
#define SORT_4(a) SORT_2(a) SORT_2(a + 2) MERGE_4(a, 1)
#define SORT_8(a) SORT_4(a) SORT_4(a + 4) MERGE_8(a, 1)
#define SORT_16(a) SORT_8(a) SORT_8(a + 8) MERGE_16(a, 1)

void sort_batch() {
    SORT_16(0)
    SORT_16(16)
    MERGE_32(0, 1)
}
