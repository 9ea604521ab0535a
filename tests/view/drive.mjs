// Opens pages of `bipc view` in Chromium and uses them as a person does. Called by test_page.py:
//     node drive.mjs CHROMIUM CASES.json FOLDER-OF-SCREENSHOTS FOLDER-OF-GOLDEN-PICTURES [--update]
// Prints a line for each case: "ok NAME" or "FAILED NAME: why".
import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(pathToFileURL((process.env.NODE_PATH || "/usr/lib/node_modules").split(":")[0] + "/x.js"))("playwright-core");
const [program, casesFile, screenshots, pictures, update] = process.argv.slice(2);
const cases = JSON.parse(readFileSync(casesFile, "utf8"));
const browser = await chromium.launch({ executablePath: program, args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"] });

function expect(is, what) {
  if (!is) throw new Error(what);
}

// Golden pictures are small, and compared by the means of blocks, so that the fonts of a machine do not matter.
const kWidth = 200, kBlock = 5;
const tool = await (await browser.newContext()).newPage();
/** The pixels of a PNG, made `kWidth` wide, and that as a PNG again. */
const reduced = (png) => tool.evaluate(async ([url, width]) => {
  const image = await createImageBitmap(await (await fetch(url)).blob());
  const height = Math.max(1, Math.round((image.height * width) / image.width));
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width, height });
  const pen = canvas.getContext("2d");
  pen.imageSmoothingQuality = "high";
  pen.drawImage(image, 0, 0, width, height);
  return { height, pixels: [...pen.getImageData(0, 0, width, height).data], png: canvas.toDataURL("image/png").split(",")[1] };
}, ["data:image/png;base64," + png.toString("base64"), kWidth]);
/** The root of the mean of the squares by which blocks differ, of 255; much if the heights are not alike. */
function distance(a, b) {
  if (Math.abs(a.height - b.height) > Math.max(a.height, b.height) / 10) return 255;
  const height = Math.min(a.height, b.height);
  let sum = 0, blocks = 0;
  for (let y = 0; y < height; y += kBlock)
    for (let x = 0; x < kWidth; x += kBlock, ++blocks) {
      let worst = 0;
      for (let colour = 0; colour < 3; ++colour) {
        let difference = 0, count = 0;
        for (let v = y; v < Math.min(height, y + kBlock); ++v)
          for (let u = x; u < Math.min(kWidth, x + kBlock); ++u, ++count) difference += a.pixels[(v * kWidth + u) * 4 + colour] - b.pixels[(v * kWidth + u) * 4 + colour];
        worst = Math.max(worst, Math.abs(difference / count));
      }
      sum += worst * worst;
    }
  return Math.sqrt(sum / blocks);
}
async function distanceFromGolden(page, { of, golden }) {
  const file = pictures + "/" + golden + ".png", now = await reduced(await page.locator(of).screenshot());
  if (update && !page.isChanged) writeFileSync(file, Buffer.from(now.png, "base64"));
  return distance(now, await reduced(readFileSync(file)));
}

const position = (page) => page.evaluate(() => window.page.position);
const text = (page, selector) => page.textContent(selector);

/** What holds on every page with a run: keys walk it, buttons and clicks do the same. */
async function walk(page) {
  const length = await page.evaluate(() => window.page.run.length);
  expect(length > 0, "the run has no step");
  await page.keyboard.press("Home");
  expect((await position(page)) === 0, "Home does not go to the initial state");
  expect((await page.locator("#back").isDisabled()), "there is no way back from the initial state");
  await page.keyboard.press("ArrowRight");
  expect((await position(page)) === 1, "the right arrow is no step");
  expect((await page.locator(".fired").count()) > 0 || (await page.evaluate(() => window.page.step.connector < 0 || window.page.picture.nets.length === 0 || !window.page.picture.nets.some((n) => n.first <= window.page.step.connector && window.page.step.connector <= n.last))), "the step's connector is not marked");
  await page.keyboard.press("ArrowLeft");
  expect((await position(page)) === 0, "the left arrow is no step back");
  const forward = await page.evaluate(() => {
    // Each state that is reached forwards is reached backwards.
    const p = window.page, seen = [], most = Math.min(p.run.length, 600);
    for (let k = 0; k <= most; ++k) (p.go(k), seen.push(JSON.stringify(p.state)));
    for (let k = most; k >= 0; --k) if ((p.go(k), JSON.stringify(p.state) !== seen[k])) return k;
    return -1;
  });
  expect(forward === -1, "state " + forward + " is another one on the way back");
  await page.keyboard.press("2");
  const taken = page.locator("#panel button.changed");
  if ((await taken.count()) > 0) {
    await taken.first().click();
    expect((await position(page)) === 1, "a click on the candidate that the run takes does not take it");
  }
  for (const key of "1234567") {
    await page.keyboard.press(key);
    expect((await text(page, "#panel")) !== "" || (await page.locator("#panel canvas, #panel svg").count()) > 0, "panel " + key + " is empty");
  }
  await page.keyboard.press("5");
  const bar = await page.locator("#panel canvas").boundingBox();
  await page.mouse.click(bar.x + bar.width - 12, bar.y + 6);
  expect((await position(page)) >= length - Math.max(2, length / 20), "a click on the timeline's end does not go there");
  await page.keyboard.press("1");
  await page.locator("#panel .row-link").nth(0).focus();
  await page.keyboard.press("Enter");
  expect((await page.evaluate(() => window.page.atom)) === 0, "Enter on a component does not choose it");
  expect((await page.locator("#automaton [data-place]").count()) > 0, "no automaton is shown");
  expect((await page.locator("#automaton .here").count()) > 0, "the automaton shows no current place");
}

/** Labels of the structure stay in their boxes with the browser's own fonts. */
async function measure(page) {
  const outside = await page.evaluate(() => {
    const found = [];
    for (const frame of document.querySelectorAll("#canvas .atom > .frame, #canvas .closed > .frame")) {
      const box = frame.getBBox();
      for (const label of frame.parentNode.querySelectorAll(":scope > text")) {
        const b = label.getBBox();
        if (b.x < box.x - 1 || b.x + b.width > box.x + box.width + 1) found.push(label.textContent);
      }
    }
    return found;
  });
  expect(outside.length === 0, "labels outside of their boxes: " + outside.slice(0, 5).join(", "));
}

const actions = {
  walk,
  measure,
  /** The deadlock of the philosophers, opened at its end and walked back to the last state with a choice. */
  async deadlock(page) {
    expect((await position(page)) === (await page.evaluate(() => window.page.run.length)), "the page does not open at the deadlock");
    expect((await page.locator("#waits path.waits").count()) > 2, "the cycle is not drawn");
    expect((await page.locator("#canvas .stuck").count()) > 2, "who waits is not marked");
    await page.keyboard.press("7");
    expect((await text(page, "#panel")).includes("cycle: "), "the story of the deadlock is missing");
    await page.keyboard.press("c");
    const here = await position(page);
    expect(here < (await page.evaluate(() => window.page.run.length)), "c does not go back");
    expect((await page.locator("#panel .row-link").count()) > 1, "there is no other choice where c leads");
    expect((await page.locator("#panel .row-link:not(:disabled)").count()) === 1, "the choice of the run is not the only one to click");
    expect((await page.locator("#waits path.waits").count()) === 0, "the cycle is still drawn");
  },
  /** The deadlock in a live page: back to the first wrong decision, another choice, and the run goes on. */
  async anotherChoice(page) {
    const length = await page.evaluate(() => window.page.run.length);
    expect((await page.locator("#waits path.waits").count()) > 2, "the cycle is not drawn");
    await page.keyboard.press("c");
    const here = await position(page);
    expect(here > 0 && here < length, "c does not go back to a decision");
    const other = page.locator("#panel .row-link:not(.changed)").first();
    expect(await other.isEnabled(), "another choice cannot be taken");
    const wanted = (await other.textContent()).replace(/^\[\d+\] /, "");
    await other.click();
    await page.waitForFunction((k) => window.page.position === k && window.page.run.length === k, here + 1);
    expect((await page.evaluate(() => window.page.step.text.replace(/\bROOT\./g, ""))) === wanted, "another step was taken than the one clicked");
    expect((await page.locator("#waits path.waits").count()) === 0, "the cycle is still drawn");
    expect((await page.locator("#canvas .fired").count()) > 0, "the connector of the step is not marked");
    for (let k = 0; k < 3; ++k) {
      const before = await position(page);
      await page.keyboard.press("ArrowRight");
      await page.waitForFunction((k) => window.page.position === k + 1, before);
    }
    const now = await page.evaluate(() => window.page.run.length);
    expect(now === here + 4, "the run does not go on: " + now + " steps instead of " + (here + 4));
  },
  /** A served model that is paused: into the deadlock, steps undone to the first wrong decision, another choice, and on. */
  async attached(page) {
    const steps = () => page.evaluate(() => window.page.live.model.steps);
    const reach = (count) => page.waitForFunction((k) => window.page.live.model.steps === k && window.page.live.canFire && window.page.run.choices(window.page.position).isKnown, count);
    const click = async (name) => {
      const before = await steps();
      await page.locator("#panel .row-link", { hasText: name }).first().click();
      await reach(before + 1);
    };
    await reach(0);
    expect((await text(page, "#model-status")).startsWith("operator · paused"), "the page does not say that the model is paused");
    for (let k = 0; k < 5; ++k) await click("left[" + k + "]");
    expect((await text(page, "#panel")).includes("Nothing is possible here"), "there is a choice in the deadlock");
    await page.keyboard.press("w");
    await page.waitForFunction(() => window.page.live.model.ended && window.page.run.end);
    expect((await page.locator("#waits path.waits").count()) > 2, "the cycle is not drawn");
    await page.keyboard.press("7");
    expect((await text(page, "#panel")).includes("cycle: "), "the story of the deadlock is missing");
    await page.keyboard.press("2");
    for (const count of [4, 3]) {
      await page.keyboard.press("b");
      await reach(count);
    }
    expect((await page.locator("#waits path.waits").count()) === 0, "the cycle is still drawn");
    await click("right[2]");
    expect((await page.locator("#canvas .fired").count()) > 0, "the connector of the step is not marked");
    expect((await page.locator("#canvas .acted").count()) === 2, "who took part is not marked");
    for (let k = 0; k < 3; ++k) {
      const before = await steps();
      await page.keyboard.press("w");
      await reach(before + 1);
    }
    // An earlier state is looked at, not changed.
    await page.keyboard.press("Home");
    expect((await page.locator("#panel .row-link:not(:disabled):not(.changed)").count()) === 0, "a candidate of an earlier state can be taken");
    await page.keyboard.press("End");
    await page.keyboard.press("8");
    await page.focus("#why");
    await page.keyboard.type("table.right[0]");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => document.querySelector("#why-text").textContent.includes("possible"));
    await page.evaluate(() => document.activeElement.blur());
  },
  /** A served model that runs in real time: the page follows it; a pause stops it, and it goes on. */
  async watched(page) {
    await page.waitForFunction(() => window.page.run.length > 3 && window.page.position === window.page.run.length);
    expect((await page.evaluate(() => window.page.run.instant(window.page.run.length))) > 0, "no time passes");
    await page.keyboard.press("2");
    await page.waitForFunction(() => document.querySelector("#panel").textContent.includes("The model went on"));
    await page.click("#pause");
    await page.waitForFunction(() => window.page.live.model.paused);
    await page.click("#resume");
    await page.waitForFunction(() => !window.page.live.model.paused);
    // The clocks of the chosen component beside its data, and as lines.
    await page.keyboard.press("1");
    await page.waitForFunction(() => /train\[0\].*x = \d/.test(document.querySelector("#panel").textContent) && window.page.run.sets.size > 0);
    const ahead = await page.evaluate(() => {
      const p = window.page, wrong = [];
      p.run.atoms.forEach(([path], atom) => p.run.clocksOf(atom).forEach(([name], clock) => {
        for (let k = 0; k <= p.run.length; ++k) if (p.run.clock(p.run.at(k), atom, clock, k) < 0) wrong.push(path + "." + name + " at " + k);
      }));
      return wrong.join(", ");
    });
    expect(ahead === "", "negative: " + ahead);
    await page.keyboard.press("6");
    expect((await page.locator("#panel path.clock").count()) > 0, "no clock is plotted");
    await page.keyboard.press("Home");
    await page.waitForFunction((k) => window.page.run.length > k + 1, await page.evaluate(() => window.page.run.length));
    expect((await position(page)) === 0, "who looks at an earlier state is taken away from it");
    await page.keyboard.press("End");
  },
  /** Bars of services of modules: those that were asked for, from the request on, and nothing where they rest. */
  async services(page) {
    await page.keyboard.press("5");
    await page.locator("#panel select").selectOption("services");
    const found = await page.evaluate(() => {
      const p = window.page, known = p.timeline.services, rows = p.timeline.rows(p.shownAtoms()), wrong = [];
      const atoms = new Map([...known].map(([atom, name]) => [name, atom]));
      for (const { name, bars } of rows) {
        const atom = atoms.get(name);
        for (let k = 0; k <= p.run.length; ++k) {
          const isShown = bars.some(([from, to]) => from <= k && k < to);
          if (k < p.run.length && isShown !== (p.run.at(k).places[atom] !== "ethr")) wrong.push(name + " at " + k);
        }
      }
      const used = [...known.keys()].filter((atom) => p.run.stays()[atom].length > 1).length;
      return { known: known.size, rows: rows.length, used, wrong: wrong.slice(0, 3).join(", "), last: rows.length && rows[0].bars[0][1] };
    });
    expect(found.known > 100 && found.rows > 0 && found.rows < found.known, "services: " + JSON.stringify(found));
    expect(found.rows === found.used && found.wrong === "", "bars of services: " + JSON.stringify(found));
    expect((await page.locator("#panel canvas").getAttribute("aria-label")) === found.rows + " services over the run", "the chart does not say what it shows");
    await page.locator("#panel select").selectOption("components");
    expect((await page.locator("#panel canvas").getAttribute("aria-label")).startsWith("places of "), "there is no way back to the components");
    await page.locator("#panel select").selectOption("services");
    await page.evaluate(() => document.activeElement.blur());
  },
  /** The list of steps: each position is shown, and none makes a row anew. */
  async stepList(page) {
    await page.keyboard.press("3");
    await page.keyboard.press("Home");
    const counted = await page.evaluate(async () => {
      const p = window.page, panel = document.querySelector("#panel"), shown = [];
      let made = 0;
      const watcher = new MutationObserver((records) => (made += records.length));
      watcher.observe(panel, { childList: true, subtree: true });
      for (let k = 0; k <= 40; ++k) {
        p.go(Math.round((p.run.length * k) / 40));
        const now = panel.querySelectorAll(".now");
        shown.push(now.length === 1 && (p.position === 0 || now[0].textContent.startsWith("#" + (p.position - 1) + p.step.text.replace(/\bROOT\./g, ""))));
      }
      await new Promise((done) => setTimeout(done));
      watcher.disconnect();
      return { made, rows: panel.querySelectorAll("[role=listitem]").length, wrong: shown.indexOf(false) };
    });
    expect(counted.made === 0, counted.made + " changes of the list's elements in 41 positions");
    expect(counted.rows < 60, counted.rows + " rows are in the page");
    expect(counted.wrong < 0, "the step of position " + counted.wrong + " of 40 is not the marked one");
    await page.keyboard.press("Home");
    const first = await text(page, "#panel [role=listitem] span");
    await page.hover("#panel");
    await page.mouse.wheel(0, 200);
    await page.waitForFunction((before) => document.querySelector("#panel [role=listitem] span").textContent !== before, first);
    expect((await position(page)) === 0, "the wheel takes a step");
    await page.locator("#panel [role=listitem]:not([hidden]) .row-link").nth(2).click();
    expect((await position(page)) === 12, "a click on the third row after ten goes to " + (await position(page)));
  },
  /** Keyboard only: a breakpoint, a run to it, a watched expression, a reason, back, a random step, a trace. */
  async drive(page) {
    await page.keyboard.press("Home");
    await page.keyboard.press("w");
    await page.waitForFunction(() => window.page.position === 1 && window.page.run.length === 1);
    await page.keyboard.press("8");
    const enter = async (id, text) => {
      await page.focus(id);
      await page.keyboard.type(text);
      await page.keyboard.press("Enter");
    };
    const at = await position(page);
    await enter("#watch", "table.phil[2]@EATS");
    await page.waitForFunction(() => /= (true|false)/.test(document.querySelector("#watches").textContent));
    await enter("#breakpoint", "nobody@EATS");
    await page.waitForFunction(() => document.querySelector("#said").textContent.includes("nobody"));
    await page.fill("#breakpoint", "");
    await enter("#breakpoint", "table.phil[2]@EATS");
    await page.waitForFunction(() => document.querySelector("#breakpoints").textContent.includes("phil[2]"));
    await enter("#until", "");
    await page.waitForFunction(() => document.querySelector("#said").textContent.includes("breakpoint table.phil[2]@EATS") || window.page.run.end);
    await page.waitForFunction(() => !window.page.live.isMoving);
    if (!(await page.evaluate(() => window.page.run.end)))
      await page.waitForFunction(() => document.querySelector("#watches").textContent.includes("= true"));
    expect((await position(page)) > at, "the run does not reach the breakpoint");
    await enter("#why", "table.right[2]");
    await page.waitForFunction(() => document.querySelector("#why-text").textContent.includes("possible"));
    await page.evaluate(() => document.activeElement.blur());
    await page.keyboard.press("Home");
    await page.keyboard.press("w");
    await page.waitForFunction(() => window.page.position === 1 && window.page.run.length === 1);
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
    const trace = readFileSync(await download.path(), "utf8");
    expect(trace.split("\n").length > 2 && trace.includes("ROOT."), "the trace is not saved");
    await page.keyboard.press("1");
  },
  /** Time passes to where a step becomes possible, and that one is taken. */
  async timed(page) {
    await page.keyboard.press("2");
    for (let k = 0; k < 12; ++k) {
      const here = await position(page);
      await page.waitForFunction(() => document.querySelector("#panel button:not(:disabled)"));
      await page.locator("#panel button:not(:disabled)").last().click();
      await page.waitForFunction((k) => window.page.position === k + 1, here);
    }
    expect((await page.evaluate(() => window.page.run.instant(window.page.run.length))) > 0, "no time has passed");
  },
  async steps(page) {
    for (const key of ["w", "w", "ArrowRight", "ArrowRight"]) {
      const here = await position(page);
      await page.keyboard.press(key);
      await page.waitForFunction((k) => window.page.position === k + 1, here);
    }
  },
  async search(page, wanted) {
    await page.keyboard.press("/");
    await page.keyboard.type(wanted);
    expect((await page.locator("#canvas .found").count()) > 0, "nothing is found");
    await page.keyboard.press("Enter");
    expect((await text(page, "#atom-name")).toLowerCase().includes(wanted), "Enter does not choose what was found");
    await page.keyboard.press("Escape");
  },
  async plot(page) {
    await page.keyboard.press("6");
    expect((await page.locator("#panel svg path").count()) > 0, "nothing is plotted");
  },
  /** Clocks run with time and are set by steps; the plot has a line for each. */
  async clocks(page) {
    await page.keyboard.press("1");
    const wrong = await page.evaluate(() => {
      const p = window.page, atom = p.run.atoms.findIndex(([path]) => path.endsWith("train[0]"));
      if (p.run.clocksOf(atom).length !== 1 || p.run.clocksOf(atom)[0][0] !== "x") return "the train has no clock x";
      let sets = 0, runs = 0;
      for (let k = 1; k <= p.run.length; ++k) {
        const before = p.run.clock(p.run.at(k - 1), atom, 0, k - 1), now = p.run.clock(p.run.at(k), atom, 0, k), passed = (p.run.instant(k) - p.run.instant(k - 1)) / 1e9;
        const place = p.run.at(k).places[atom], was = p.run.at(k - 1).places[atom];
        if (was === "FAR" && place === "NEAR") (++sets, now === 0 || (sets = -1e9));
        else if (Math.abs(now - before - passed) > 1e-4) return "at " + k + " x is " + now + " after " + before + " and " + passed + " s";
        else runs += passed > 0;
        // Invariants of the model.
        if ((place === "NEAR" && now > 5) || (place === "ON" && now > 7)) return "x is " + now + " at " + place;
      }
      return sets > 0 && runs > 0 ? "" : "x is never set, or never runs";
    });
    expect(wrong === "", wrong);
    await page.keyboard.press("End");
    expect(/x = \d/.test(await text(page, "#panel")), "no clock in the state");
    await page.keyboard.press("6");
    expect((await page.locator("#panel path.clock").count()) > 0, "no clock is plotted");
  },
  /** Every invariant of the proof holds in every state of the run; a click marks what it speaks of. */
  async proof(page) {
    const wrong = await page.evaluate(() => {
      const p = window.page, seen = new Set();
      for (let k = 0; k <= p.run.length; ++k) {
        p.go(k);
        for (const row of p.proof.rows) {
          const holds = row.terms.map((term) => p.proof.termHolds(term));
          if (row.kind === "sum" || row.kind === "equation") {
            const sum = p.proof.sum(row);
            if (sum === "") continue;
            if (sum !== row.total) return row.kind + " #" + row.number + " is " + sum + " instead of " + row.total + " at " + k;
          } else if (holds.includes(null)) continue;
          else if (row.kind === "one-token" ? holds.filter(Boolean).length !== 1 : !holds.includes(true)) return row.kind + " #" + row.number + " does not hold at " + k;
          seen.add(row.number);
        }
      }
      return seen.size === p.proof.rows.length ? "" : seen.size + " of " + p.proof.rows.length + " invariants could be looked at";
    });
    expect(wrong === "", wrong);
    expect((await page.locator("#panel tr").count()) > 0, "no invariant is listed");
    await page.locator("#panel td:nth-child(2) .row-link").first().click();
    expect((await page.locator("#canvas .invariant").count()) > 1, "the components of the invariant are not marked");
    expect((await page.locator("#automaton .invariant").count()) > 0, "the places of the invariant are not marked");
  },
  /** Of a proof with time: each state of the run lies in a zone of its places and data. */
  async zones(page) {
    const wrong = await page.evaluate(() => {
      const p = window.page, outside = [];
      for (let k = 0; k <= p.run.length; ++k) {
        p.go(k);
        if (!p.proof.zones().some((zone) => zone.holds)) outside.push(k);
      }
      return outside.slice(0, 5).join(", ");
    });
    expect(wrong === "", "in no zone: positions " + wrong);
    expect((await page.locator("#panel tr.now").count()) > 0, "no zone is marked");
    // A clock that is ahead of its time is in none.
    const isIn = await page.evaluate(() => {
      const p = window.page;
      p.go(p.run.length);
      p.state.clocks = p.state.clocks.map((row) => row.map(([value, since, speed]) => [value - 1e12, since, speed]));
      return p.proof.zones().some((zone) => zone.holds);
    });
    expect(!isIn, "clocks below 0 are in a zone");
    await page.evaluate(() => window.page.go(0));
  },
  /** A long run is scrubbed in every panel. What it takes is printed; `most` ms only tell what draws all steps. */
  async scrub(page, most) {
    const slow = [];
    for (const key of "12345678".slice(0, await page.locator("#tabs button").count())) {
      await page.keyboard.press(key);
      const took = await page.evaluate(async () => {
        const p = window.page, times = [];
        for (let k = 0; k < 40; ++k) {
          const begin = performance.now();
          p.go(Math.round((p.run.length * ((k * 17) % 40)) / 40));
          document.body.offsetHeight;
          times.push(performance.now() - begin);
          await new Promise((done) => setTimeout(done));
        }
        // The first one may draw what all others show.
        return times.slice(1).reduce((sum, time) => sum + time) / (times.length - 1);
      });
      slow.push(key + ": " + took.toFixed(1));
      expect(took < most, "panel " + key + " takes " + took.toFixed(1) + " ms for a position");
    }
    return "ms for a position, by panel: " + slow.join(", ");
  },
  /** A part of the page looks as it did; `most` is the distance that is allowed. */
  async picture(page, what) {
    const far = await distanceFromGolden(page, what);
    expect(far <= what.most, what.golden + " differs by " + far.toFixed(1) + " from the golden picture");
    return what.golden + ": " + far.toFixed(1);
  },
  /** The golden picture tells this state, or this page without a part, from its own. */
  async otherPicture(page, what) {
    page.isChanged = true;
    const far = await distanceFromGolden(page, what);
    expect(far > what.most, what.golden + " differs by " + far.toFixed(1) + " only from another picture");
    return "other than " + what.golden + ": " + far.toFixed(1);
  },
  /** Styles of the page, in place of those of the step before. */
  async style(page, rules) {
    page.isChanged = true;
    await page.evaluate((text) => {
      document.querySelector("#of-the-test")?.remove();
      document.head.append(Object.assign(document.createElement("style"), { id: "of-the-test", textContent: text }));
    }, rules);
  },
  async levels(page) {
    const count = await page.locator("#levels option").count();
    expect(count > 1, "there is one level only");
    const boxes = new Set();
    for (let k = 0; k < count; ++k) {
      await page.selectOption("#levels", String(k));
      boxes.add(await page.locator("#canvas [data-path]").count());
    }
    expect(boxes.size > 1, "all levels show the same");
    await page.selectOption("#levels", "0");
  },
  async key(page, wanted) {
    await page.keyboard.press(wanted);
  },
};

let failed = 0;
/** A page of another origin: it opens no socket, and reads nothing. */
async function foreign(context, address) {
  const page = await context.newPage();
  await page.goto("data:text/html,<p>another page</p>");
  const heard = await page.evaluate(async (address) => {
    const socket = new WebSocket(address.replace(/^http/, "ws") + "live");
    const opened = await new Promise((done) => {
      socket.addEventListener("open", () => done(true));
      socket.addEventListener("error", () => done(false));
      setTimeout(() => done(false), 5000);
    });
    const read = await fetch(address, { signal: AbortSignal.timeout(5000) }).then((answer) => answer.text(), () => "");
    return [opened, read];
  }, address);
  expect(!heard[0], "a page of another origin opens the socket");
  expect(heard[1] === "", "a page of another origin reads the page");
  await page.close();
}

for (const { name, file, address, dark, steps, most } of cases) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, colorScheme: dark ? "dark" : "light" });
  const page = await context.newPage();
  const complaints = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => request.url().startsWith("file:") || (address && (request.url() === address || /^(data|blob):/.test(request.url()))) || complaints.push("asks for " + request.url()));
  try {
    if (address) await foreign(context, address);
    // The best of three: another process may have the processor. Bounded, as a page whose script failed is never there.
    let paint = Infinity;
    for (let k = 0; k < 3 && paint >= most; ++k) {
      await page.goto(address || pathToFileURL(file).href);
      await page.waitForFunction(() => performance.getEntriesByName("first-contentful-paint").length > 0 && window.page, null, { timeout: 30000 }).catch(() => {
        throw new Error("the page does not come: " + complaints.join("; "));
      });
      paint = Math.min(paint, await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0].startTime));
    }
    expect(paint < most, "the first paint takes " + Math.round(paint) + " ms");
    if (address) await page.waitForFunction(() => window.page.live.greeted);
    const said = [];
    for (const [action, argument] of steps) said.push(await actions[action](page, argument));
    await page.screenshot({ path: screenshots + "/" + name + ".png" });
    expect(complaints.length === 0, complaints.join("; "));
    console.log("ok " + name + " (first paint " + Math.round(paint) + " ms)" + said.filter(Boolean).map((text) => " " + text).join(""));
  } catch (error) {
    ++failed;
    console.log("FAILED " + name + ": " + String(error.message).split("\n").slice(0, 3).join(" ") + (String(error.stack).match(/drive\.mjs:\d+/) || [""])[0]);
    await page.screenshot({ path: screenshots + "/" + name + ".png" });
  }
  await context.close();
}
await browser.close();
process.exit(failed ? 1 : 0);
