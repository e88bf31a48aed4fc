// The command line: what was typed, what the board said and refused, and the lines before by the arrow keys.

const $ = (id) => document.getElementById(id);
const MOST = 50, LONGEST = 6000;

export class Typed {
  // order(name, fields): a promise of the answer; errorText(number).
  constructor(order, errorText) {
    this.lines = [];
    this.at = 0;
    $("line-form").onsubmit = (event) => {
      event.preventDefault();
      const line = $("line").value.trim();
      if (!line) return;
      this.lines = this.lines.filter((each) => each !== line).concat(line).slice(-MOST);
      this.at = this.lines.length;
      this.say(`> ${line}`);
      $("line").select();
      order("line", { line }).then(({ error }) => { if (error) this.say(errorText(error)); });
    };
    $("line").onkeydown = (event) => {
      const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!by || !this.lines.length) return;
      event.preventDefault();
      this.at = Math.max(0, Math.min(this.lines.length, this.at + by));
      $("line").value = this.lines[this.at] || "";
    };
  }

  say(text) {
    $("said").textContent = ($("said").textContent + text + "\n").slice(-LONGEST);
    $("said").scrollTop = $("said").scrollHeight;
  }
}
