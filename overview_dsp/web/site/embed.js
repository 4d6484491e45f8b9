// Element that shows an exported folder within an article:
//
//     <script src="match/embed.js" async></script>
//     <overview-timeline src="match/" title="France - Croatia"></overview-timeline>
//
// Attributes: `src`, `title`, `lang`, colours (`ink`, `paper`, `soft`, `groove`), `at`, `window`, and `height`
// (px). Events, which bubble: `overview:enter` at each passed event (detail: kind, label, time_s, text) and
// `overview:move` (position, time_s, text). An iframe in the element is used; without scripts it stands alone.

(() => {
  const LEAST_PX = 380;
  const MOST_PX = 560;
  const SHARE = 0.62; // of the width
  const PASSED_ON = ["title", "lang", "ink", "paper", "soft", "groove", "at", "window"];

  class OverviewTimeline extends window.HTMLElement {
    static observedAttributes = ["src", "height", ...PASSED_ON];

    constructor() {
      super();
      /** @type {HTMLIFrameElement | null} */
      this.frame = null;
      this.needed = 0; // height (px) that the page asks for
      /** @param {MessageEvent} event */
      this.receive = ({ source, data }) => {
        if (!this.frame || source !== this.frame.contentWindow || !data?.overview) return;
        const { overview: name, ...detail } = data;
        if (name === "height") this.resize(detail.height);
        else this.dispatchEvent(new window.CustomEvent(`overview:${name}`, { bubbles: true, detail }));
      };
      this.sizes = new ResizeObserver(() => this.resize(this.needed));
    }

    connectedCallback() {
      this.frame ??= this.querySelector("iframe") ?? this.appendChild(document.createElement("iframe"));
      this.frame.loading = "lazy";
      this.frame.allow = "autoplay; accelerometer; gyroscope; fullscreen; web-share";
      Object.assign(this.style, { display: "block" });
      Object.assign(this.frame.style, { display: "block", width: "100%", border: "0" });
      window.addEventListener("message", this.receive);
      this.sizes.observe(this);
      this.show();
    }

    disconnectedCallback() {
      window.removeEventListener("message", this.receive);
      this.sizes.disconnect();
    }

    attributeChangedCallback() {
      if (this.isConnected && this.frame) this.show();
    }

    show() {
      const { frame } = this;
      const src = this.getAttribute("src");
      if (!frame || src === null) return;
      const fields = new URLSearchParams({ embed: "1" });
      for (const name of PASSED_ON) {
        const value = this.getAttribute(name);
        if (value !== null) fields.set(name, value);
      }
      const address = new URL(src, document.baseURI);
      address.hash = fields.toString();
      if (frame.src !== address.href) frame.src = address.href;
      frame.title = this.getAttribute("title") ?? "A timeline that you can feel";
      this.resize(this.needed);
    }

    /** @param {number} needed */
    resize(needed) {
      this.needed = needed;
      const usual = Math.min(Math.max(SHARE * this.clientWidth, LEAST_PX), MOST_PX);
      const height = Number(this.getAttribute("height")) || Math.max(usual, needed);
      if (this.frame) this.frame.style.height = `${Math.round(height)}px`;
    }
  }

  const { customElements } = window;
  if (!customElements.get("overview-timeline")) customElements.define("overview-timeline", OverviewTimeline);
})();
