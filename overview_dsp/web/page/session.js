// Let in: the token of the address becomes a cookie, and leaves the address.

export async function enter() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  const answer = await fetch("/session", {
    method: "POST",
    headers: { Authorization: `Bearer ${token}` },
  });
  if (!answer.ok) throw new Error((await answer.text()).trim());
  history.replaceState(null, "", location.pathname);
}

export async function fetchData(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error((await answer.text()).trim());
  return answer.json();
}
