/* Counts allocations while a voice is played, in whatever process this is preloaded into: glibc's
   own functions do the work. Only the thread that plays is counted. */
#include <stddef.h>
#include <stdint.h>

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t), __libc_free(void *);

static __thread int counting;
static __thread long counted;

void *malloc(size_t size) { counted += counting; return __libc_malloc(size); }
void *calloc(size_t count, size_t size) { counted += counting; return __libc_calloc(count, size); }
void *realloc(void *old, size_t size) { counted += counting; return __libc_realloc(old, size); }
void *memalign(size_t at, size_t size) { counted += counting; return __libc_memalign(at, size); }
void *aligned_alloc(size_t at, size_t size) { return memalign(at, size); }
int posix_memalign(void **to, size_t at, size_t size) { return !(*to = memalign(at, size)); }
void free(void *old) { counted += counting; __libc_free(old); }

typedef int32_t stream(const void *, void *, unsigned long, const void *, unsigned long, void *);
typedef int32_t voice(void *, float *, int64_t, int32_t);

/* Blocks of a PaStreamCallback. */
long allocations_of_stream(stream *run, void *memory, float *out, long frames, long blocks) {
    counted = 0, counting = 1;
    while (blocks--) run(0, out, (unsigned long)frames, 0, 0, memory);
    counting = 0;
    return counted;
}

/* Blocks of overview_process. */
long allocations_of_voice(voice *run, void *memory, float *out, long frames, long blocks) {
    counted = 0, counting = 1;
    while (blocks--) run(memory, out, frames, 2);
    counting = 0;
    return counted;
}

/* As overview_process, but that it allocates: what must be seen. */
int32_t careless(void *memory, float *out, int64_t frames, int32_t channels) {
    void *volatile room = malloc((size_t)frames * sizeof *out);
    (void)memory, (void)channels;
    free(room);
    return 0;
}
