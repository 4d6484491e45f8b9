"""The browser page, its WebAssembly kernel, and the server of both."""
