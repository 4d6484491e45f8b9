// First the picture and its words, then everything that it is felt with.

import { Data } from "./data.js";
import { by } from "./dom.js";
import { Picture } from "./picture.js";
import { firstPart } from "./windows.js";

// not awaited: what is imported later imports this file's bundle, which has to have ended
start().catch((error) => {
  by("fault").textContent = `The page can't begin: ${error.message}`;
});

async function start() {
  const data = await Data.open();
  const { info } = data;
  by("title").textContent = info.title;
  document.title = `${info.title}: overView`;
  const picture = new Picture(by("canvas"), by("trace"), info);
  const view = await data.view(firstPart(info));
  picture.show(view);
  const { begin } = await import("./page.js");
  await begin(data, picture, view);
}
