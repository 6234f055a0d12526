// `sort_list(first)` sorts a list in memory, and returns its first record.
#include "lists.glsl"

#if STORAGE == STORAGE_COUNTED
#include "heap_sort.glsl"
#else
#include "merge_sort.glsl"
#endif
