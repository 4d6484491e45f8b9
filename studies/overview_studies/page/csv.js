// The answers as a CSV, for a folder without a server; docs/explanation/study-format.md has its columns.

const COLUMNS = ["session", "participant", "list", "trial", "received_utc", "response", "correct",
  "rt_ms", "row"];

/** A field: quoted where it holds what would end it. */
const field = (value) => {
  const text = typeof value === "string" ? value : JSON.stringify(value ?? null);
  if (value === null || value === undefined) return "";
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** `sessions`: [session, rows] each; `rows` are [id, { received_utc, row }]. */
export function csvOf(sessions) {
  const lines = sessions.flatMap(([{ session, participant, list }, rows]) =>
    rows.map(([trial, { received_utc, row }]) =>
      [session, participant, list, trial, received_utc, row.response, row.correct, row.rt_ms,
        JSON.stringify(row)].map(field).join(",")));
  return `${[COLUMNS.join(","), ...lines].join("\r\n")}\r\n`;
}
