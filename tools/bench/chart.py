"""A chart of tools/bench/engine's rows: a small panel a workload, both axes logarithmic, a line an executor. Plain SVG."""
import html
import math

COLOURS = {"limit": "#222222", "c++": "#0072b2", "jit-O2": "#009e73", "jit-O0": "#e69f00", "interp": "#cc79a7", "naive": "#999999"}
WIDTH, HEIGHT, COLUMNS = 300, 220, 4
LEFT, RIGHT, TOP, BOTTOM = 52, 12, 30, 34


def decades(low, high):
    return [10.0 ** e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]


def short(value):
    for unit, name in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if value >= unit:
            return f"{value / unit:g}{name}"
    return f"{value:g}"


def panel(name, rows, executors, x0, y0):
    out = [f'<text x="{x0 + LEFT}" y="{y0 + 18}" font-weight="bold">{html.escape(name)}</text>']
    points = [(r["n"], c["ns"]) for r in rows for e, c in r["executors"].items() if e in executors and c["ns"] > 0]
    if not points:
        return out
    ns = decades(min(p[1] for p in points), max(p[1] for p in points))
    sizes = sorted({p[0] for p in points})
    low, high = math.log10(ns[0]), math.log10(ns[-1]) or 1
    first, last = math.log10(sizes[0]), math.log10(sizes[-1])

    def x(n):
        span = last - first or 1
        return x0 + LEFT + (math.log10(n) - first) / span * (WIDTH - LEFT - RIGHT)

    def y(v):
        return y0 + HEIGHT - BOTTOM - (math.log10(v) - low) / ((high - low) or 1) * (HEIGHT - TOP - BOTTOM)

    for v in ns:
        out.append(f'<line x1="{x0 + LEFT}" x2="{x0 + WIDTH - RIGHT}" y1="{y(v):.1f}" y2="{y(v):.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{x0 + LEFT - 4}" y="{y(v) + 4:.1f}" text-anchor="end">{short(v)}</text>')
    for n in sizes:
        out.append(f'<text x="{x(n):.1f}" y="{y0 + HEIGHT - BOTTOM + 14}" text-anchor="middle">{short(n)}</text>')
    for executor in executors:
        line = [(x(r["n"]), y(r["executors"][executor]["ns"])) for r in rows
                if r["executors"].get(executor, {}).get("ns", 0) > 0]
        path = " ".join(f"{px:.1f},{py:.1f}" for px, py in line)
        out.append(f'<polyline points="{path}" fill="none" stroke="{COLOURS[executor]}" stroke-width="1.5"/>')
        out += [f'<circle cx="{px:.1f}" cy="{py:.1f}" r="2" fill="{COLOURS[executor]}"/>' for px, py in line]
    return out


def draw(rows, executors):
    names = list(dict.fromkeys(r["workload"] for r in rows))
    lines = (len(names) + COLUMNS - 1) // COLUMNS
    width, height = WIDTH * min(COLUMNS, len(names)), HEIGHT * lines + 30
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="10">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    for i, name in enumerate(names):
        mine = [r for r in rows if r["workload"] == name]
        out += panel(name, mine, executors, i % COLUMNS * WIDTH, i // COLUMNS * HEIGHT)
    x = LEFT
    for executor in executors:
        out.append(f'<rect x="{x}" y="{height - 20}" width="10" height="10" fill="{COLOURS[executor]}"/>')
        out.append(f'<text x="{x + 14}" y="{height - 11}">{html.escape(executor)}</text>')
        x += 70
    out.append(f'<text x="{x}" y="{height - 11}">CPU ns an interaction over size</text></svg>')
    return "\n".join(out) + "\n"
