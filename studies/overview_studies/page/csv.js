// Answers as CSV, for a folder without a server. docs/explanation/study-format.md lists the columns.

const COLUMNS = ["session", "participant", "list", "trial", "received_utc", "response", "correct",
  "rt_ms", "row"];

/** Return a field, quoted if it contains a separator or quote. */
const field = (value) => {
  const text = typeof value === "string" ? value : JSON.stringify(value ?? null);
  if (value === null || value === undefined) return "";
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** Return the CSV of `sessions`: [session, rows] pairs; `rows` are [id, { received_utc, row }]. */
export function csvOf(sessions) {
  const lines = sessions.flatMap(([{ session, participant, list }, rows]) =>
    rows.map(([trial, { received_utc, row }]) =>
      [session, participant, list, trial, received_utc, row.response, row.correct, row.rt_ms,
        JSON.stringify(row)].map(field).join(",")));
  return `${[COLUMNS.join(","), ...lines].join("\r\n")}\r\n`;
}
