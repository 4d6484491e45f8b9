/* Counts what is allocated or freed while `processing`, where malloc can be interposed. */
#include <stdlib.h>

static int processing;
static long allocations;
#ifdef __GLIBC__
void *__libc_malloc(size_t);
void *__libc_calloc(size_t, size_t);
void *__libc_realloc(void *, size_t);
void __libc_free(void *);
void *malloc(size_t n) { allocations += processing; return __libc_malloc(n); }
void *calloc(size_t n, size_t m) { allocations += processing; return __libc_calloc(n, m); }
void *realloc(void *p, size_t n) { allocations += processing; return __libc_realloc(p, n); }
void free(void *p) { allocations += processing; __libc_free(p); }
#endif
