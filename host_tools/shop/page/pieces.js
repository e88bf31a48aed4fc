// A file on its way to the shop, in pieces.

const MOST = 30_000, MOST_BYTES = 44_000;  // letters of a piece; bytes of it in its order

const size = (text) => new TextEncoder().encode(JSON.stringify(text)).length;

// [{at, text, last}] of a text: each fits into one message, whatever its letters cost there. `at`: Python counts letters beyond FFFFh as one.
export function pieces(text) {
  const letters = [...text], found = [];
  for (let at = 0; at === 0 || at < letters.length;) {
    let count = MOST, piece = letters.slice(at, at + count).join("");
    while (size(piece) > MOST_BYTES) {
      count = Math.floor(count / 2);
      piece = letters.slice(at, at + count).join("");
    }
    found.push({ at, text: piece, last: at + count >= letters.length });
    at += count;
  }
  return found;
}
