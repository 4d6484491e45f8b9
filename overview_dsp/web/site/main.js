// Start of the page: first the picture, then sound and input.

import { Data } from "./data.js";
import { button, byId } from "./dom.js";
import { fit } from "./fit.js";
import { showTitle } from "./legend.js";
import { Picture } from "./picture.js";
import { firstPart } from "./windows.js";
import { NO_NETWORK, notLoaded, TRY_AGAIN } from "./words.js";

// not awaited: later imports need this script to have ended
start().catch((error) => {
  const reason = navigator.onLine ? error.message : NO_NETWORK;
  byId("fault").classList.add("link");
  byId("fault").replaceChildren(notLoaded(reason), button("", () => location.reload(), TRY_AGAIN));
  byId("stage").hidden = true;
});

async function start() {
  const data = await Data.open();
  const { info } = data;
  byId("title").textContent = byId("more-title").textContent = info.title;
  document.title = `${info.title}: overView`;
  const view = await data.view(firstPart(info));
  showTitle(info);
  fit(view, info);
  const picture = new Picture(byId("canvas"), info, view);
  const [{ begin }] = await Promise.all([import("./page.js"), import("./kernel.js")]); // in one wait
  await begin(data, picture);
}
