// The page's scripts: no name that isn't there or isn't used, nothing that hides a mistake.

const browser = ["AbortSignal", "AudioContext", "AudioWorkletNode", "Blob", "DeviceOrientationEvent",
  "EventSource", "IDBKeyRange", "IntersectionObserver", "Intl", "MutationObserver", "Option", "ResizeObserver", "SpeechSynthesisUtterance", "URL",
  "DecompressionStream", "Response", "TextDecoder", "URLSearchParams", "WebAssembly", "WebSocket", "addEventListener", "atob", "caches", "clearTimeout",
  "console", "crypto", "document",
  "fetch", "getComputedStyle", "history", "importScripts", "indexedDB", "localStorage", "location", "matchMedia",
  "navigator", "performance", "queueMicrotask", "registerProcessor", "requestAnimationFrame", "sampleRate", "self",
  "setInterval", "setTimeout", "speechSynthesis", "structuredClone", "window", "Request",
  "AudioWorkletProcessor"];

export default [
  { ignores: ["**/jspsych/", "**/bundle/"] }, // as it was published; as it is made
  {
    files: ["**/*.js"],
    languageOptions: {
      ecmaVersion: 2023,
      globals: Object.fromEntries(browser.map((name) => [name, "readonly"])),
    },
    linterOptions: { reportUnusedDisableDirectives: true },
    rules: {
      "array-callback-return": "error",
      "consistent-return": "error",
      eqeqeq: "error",
      "no-cond-assign": "error",
      "no-const-assign": "error",
      "no-dupe-keys": "error",
      "no-fallthrough": "error",
      "no-implicit-globals": "error",
      "no-self-compare": "error",
      "no-shadow": ["error", { builtinGlobals: false }],
      "no-undef": "error",
      "no-unreachable": "error",
      "no-unused-vars": ["error", { argsIgnorePattern: "^inputs$" }],
      "no-use-before-define": ["error", { functions: false, classes: false, variables: false }],
      "no-var": "error",
      "prefer-const": "error",
      "require-atomic-updates": "off",
    },
  },
];
