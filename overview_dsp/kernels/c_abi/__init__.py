"""C interface of the kernels, on plain pointers instead of numba's arrays."""
