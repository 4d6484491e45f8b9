"""The page: the kernel as WebAssembly, what runs it in a browser, and the server of all that."""
