// What pages of a model that runs elsewhere have in common: questions over a WebSocket, their answers, and what is said.
"use strict";

class Connection {
  /** `atEnd`: what is said when the other side is gone. */
  constructor(page, atEnd) {
    this.page = page;
    this.asked = new Map(); // by number: what is done with the answer
    this.next = 1;
    this.said = element("pre", { id: "said", class: "said", role: "status" });
    this.said.hidden = true;
    $("lower").insertBefore(this.said, $("panel"));
    this.socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[?#].*$/, "") + "live");
    this.socket.addEventListener("message", (event) => this.hear(JSON.parse(event.data)));
    this.socket.addEventListener("close", () => {
      this.isClosed = true;
      this.say(atEnd);
      this.page.render();
    });
  }
  ask(what, fields, then) {
    if (this.isClosed) return;
    const id = this.next++;
    this.asked.set(id, then || (() => {}));
    const message = JSON.stringify({ id, do: what, ...fields });
    // The page is shown, and may ask, before its socket is open.
    if (this.socket.readyState === WebSocket.CONNECTING) this.socket.addEventListener("open", () => this.socket.send(message));
    else this.socket.send(message);
  }
  /** Gives an answer to who has asked. */
  answer(message) {
    const then = this.asked.get(message.id);
    this.asked.delete(message.id);
    if (then) then(message);
  }
  say(text) {
    this.said.textContent = text;
    this.said.hidden = text === "";
  }
}
