"""The page: the kernel as WebAssembly, what runs it in a browser, and the bytes it is given."""
