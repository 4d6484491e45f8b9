"""C functions over the kernels, on plain pointers: what callers without numba's arrays call."""
