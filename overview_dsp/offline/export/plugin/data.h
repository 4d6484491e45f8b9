/* The images' bytes, which bundle.c includes: the assembler puts images.bin at bundle_data. */
#if defined __APPLE__
__asm__(".const\n.private_extern _bundle_data\n.p2align 3\n_bundle_data:\n"
        ".incbin \"images.bin\"\n.text\n");
#elif defined _WIN32
__asm__(".section .rdata,\"dr\"\n.globl bundle_data\n.p2align 3\nbundle_data:\n"
        ".incbin \"images.bin\"\n.text\n");
#else
__asm__(".pushsection .rodata\n.globl bundle_data\n.hidden bundle_data\n.p2align 3\n"
        "bundle_data:\n.incbin \"images.bin\"\n.popsection\n");
#endif
