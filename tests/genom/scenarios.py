"""Random GenoM 2 modules: as dictionaries for the reference, as .gen text and side file for bipc."""
import random

from reference import CODEL_OF, PERMITTED

STATE_OF = {codel: state for state, codel in CODEL_OF.items()}


def some(rng, items, most):
    items = list(items)
    return sorted(rng.sample(items, rng.randint(0, min(most, len(items)))))


def make_module(seed):
    rng = random.Random(seed)
    tasks = []
    for i in range(rng.randint(1, 2)):
        task = {"name": f"Task{i}", "period": rng.choice(["none", 1, 2, 3])}
        if rng.random() < 0.4:
            task["codel_task_main"] = f"perm{i}"
        tasks.append(task)
    names = [f"Rq{i}" for i in range(rng.randint(2, 6))]
    requests = []
    with_init = rng.random() < 0.35
    for i, name in enumerate(names):
        kind = "init" if with_init and i == 0 else rng.choice(["exec", "exec", "exec", "control"])
        request = {"name": name, "type": kind}
        if kind == "exec" or (kind == "init" and rng.random() < 0.6):
            request["exec_task"] = rng.choice(tasks)["name"]
            for codel in CODEL_OF.values():
                if rng.random() < 0.6:
                    request[codel] = f"{name.lower()}_{codel[6:]}"
        if rng.random() < 0.5:
            request["codel_control"] = f"{name.lower()}_control"
        request["fail_reports"] = [f"{name.upper()}_BAD{k}" for k in range(rng.randint(0, 2))]
        request["interrupt_activity"] = "all" if rng.random() < 0.15 else some(rng, names, 2)
        requests.append(request)
    module = {"name": rng.choice(["mod", "Nav", "laserRF"]), "tasks": tasks, "requests": requests}
    module["posters"] = [{"name": f"P{i}", "update": rng.choice(["auto", "user"]), "exec_task": rng.choice(tasks)["name"]} for i in range(rng.randint(0, 2))]
    module["yields"] = narrow(rng, module)
    return module


def narrow(rng, module):
    """Lines of the side file: permanent codels rarely fail, some codels answer less than they might, few answer nonsense."""
    yields = {}
    for task in module["tasks"]:
        if "codel_task_main" in task and rng.random() < 0.85:
            yields[task["codel_task_main"]] = ["OK"]
    for request in module["requests"]:
        for key, state in STATE_OF.items():
            if key in request and rng.random() < 0.4:
                allowed = sorted(PERMITTED[state])
                chosen = rng.sample(allowed, rng.randint(1, len(allowed)))
                if rng.random() < 0.05:
                    chosen.append("OTHER")
                yields[request[key]] = chosen
    return yields


def as_gen(module):
    out = [f"module {module['name']} {{ number: 100; internal_data: DATA; }};", "typedef struct DATA { double x; } DATA;"]
    for r in module["requests"]:
        out.append(f"request {r['name']} {{")
        out.append(f"  type: {r['type']};")
        for key in ("exec_task", "codel_control", *CODEL_OF.values()):
            if key in r:
                out.append(f"  {key}: {r[key]};")
        if r["fail_reports"]:
            out.append(f"  fail_reports: {', '.join(r['fail_reports'])};")
        listed = r["interrupt_activity"]
        out.append(f"  interrupt_activity: {listed if listed == 'all' else ', '.join(listed) or 'none'};")
        out.append("};")
    for p in module["posters"]:
        data = "type: DATA;" if p["update"] == "user" else "data: d::x;"
        out.append(f"poster {p['name']} {{ update: {p['update']}; {data} exec_task: {p['exec_task']}; }};")
    for t in module["tasks"]:
        main = f" codel_task_main: {t['codel_task_main']};" if "codel_task_main" in t else ""
        out.append(f"exec_task {t['name']} {{ period: {t['period']}; priority: 100; stack_size: 2000;{main} }};")
    return "\n".join(out) + "\n"


def as_side_file(module):
    return "".join(f"codel {name} yields {' '.join(words)}\n" for name, words in sorted(module["yields"].items()))


def instances(module, least):
    """One activity a request, and one more for what interrupts itself; for `init` "all" is everything else."""
    def of(request):
        listed = request["interrupt_activity"]
        own = request["type"] != "init" if listed == "all" else request["name"] in listed
        return max(2, least) if own else least
    return of
