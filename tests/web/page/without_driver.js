// The page's own test in a browser that nothing drives: keys, Play, and what came of them.

const until = async (what) => {
  for (let tries = 0; tries < 600; tries += 1) {
    if (what()) return;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  throw new Error(`waited in vain for ${what}: ${document.getElementById("fault").textContent}`);
};

async function told() {
  const slider = document.getElementById("slider");
  const press = (key) => slider.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true }));
  const says = () => slider.getAttribute("aria-valuetext") ?? "";
  await until(() => window.overview?.view);
  for (let i = 0; i < 3; i += 1) press("]");
  await until(() => says().includes("near miss"));
  const event = says();
  press("End");
  await until(() => says().includes("full time"));
  press("+");
  await until(() => window.overview.view.zoom === 1);
  const { playback, sound } = window.overview;
  await until(() => sound.node);
  document.getElementById("run").click();
  await until(() => playback.player.playing);
  await until(() => window.overview.cursor > 0.2);
  document.getElementById("run").click();
  await until(() => !playback.player.playing);
  return {
    event,
    swept: window.overview.cursor,
    meters: window.overview.meters,
    fault: document.getElementById("fault").textContent,
  };
}

const answer = await told().catch((error) => ({ error: String(error) }));
await fetch("told", { method: "POST", body: JSON.stringify(answer) });
