"""Drives the client over Fast DDS (client.cpp): goals of actions as Python sees them, and values of topics. Python's library only."""
import json
import queue
import subprocess
import threading
import time
import uuid

from checks import LONG  # of tests/serve, whose folder the caller has put into sys.path

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


class Goal:
    def __init__(self, action, sent):
        self.action, self.sent = action, sent
        self.id = uuid.uuid4().hex
        self.accepted = None   # not known yet
        self.answered_ms = None
        self.feedback = []
        self.status = None     # of the result
        self.result = None
        self.asked_result = False

    @property
    def report(self):
        """Of the result; of a refusal, from the feedback."""
        return self.result[-2] if self.result else self.feedback[-1][0] if self.feedback else None


class RosClient:
    def __init__(self, program, domain):
        self.process = subprocess.Popen([str(program), str(domain)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.lines = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.numbers = {}   # (action, number) -> (what, goal)
        self.goals = {}     # id -> goal
        self.statuses = {}  # action -> {id: status}
        self.cancels = {}   # number -> event
        self.topics = {}    # name -> values
        self.ends = []
        self.next = 0

    def close(self):
        if self.process.poll() is None:
            self.process.stdin.close()
            self.process.wait(20)

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(json.loads(line))

    def tell(self, *words):
        self.process.stdin.write("\t".join(words) + "\n")
        self.process.stdin.flush()

    def hear(self, seconds):
        """One event, or None."""
        try:
            event = self.lines.get(timeout=seconds)
        except queue.Empty:
            return None
        assert "error" not in event, event
        kind = event["event"]
        if kind in ("goal", "result"):
            what, goal = self.numbers.get((event["action"], event["number"]), (None, None))
            if what == "goal" and goal.accepted is None:
                goal.accepted, goal.answered_ms = event["accepted"], event["ms"] - goal.sent_ms
            elif what == "result":
                goal.status, goal.result = event["status"], event["result"]
        elif kind == "sent" and event["what"] == "goal":
            self.numbers[event["action"], event["number"]][1].sent_ms = event["ms"]
        elif kind == "feedback" and event["id"] in self.goals:
            self.goals[event["id"]].feedback.append(event["feedback"])
        elif kind == "status":
            self.statuses[event["action"]] = dict(event["goals"])
        elif kind == "cancel":
            self.cancels[event["number"]] = event
        elif kind == "topic":
            self.topics.setdefault(event["topic"], []).append(event["value"])
        elif kind == "end":
            self.ends.append(event)
        return event

    def until(self, test, seconds=LONG):
        """Listens until the test holds. False: it did not in time."""
        end = time.monotonic() + seconds
        while not test():
            if time.monotonic() > end:
                return False
            self.hear(0.05)
        return True

    # ---- what may be asked for
    def add_action(self, name, type, result):
        self.tell("action", name, type, result)
        return self.wait(name)

    def add_topic(self, name, type, format):
        self.tell("topic", name, type, format)
        return self.wait(name)

    def wait(self, name, count=1):
        """Until all its ends have found so many others: one more for each bridge that died."""
        self.tell("wait", name, str(count))
        return self._matched(name)

    def _matched(self, name):
        while True:
            event = self.hear(LONG)
            if event and event.get("name") == name:
                return event["event"] == "matched"

    def goal(self, action, *values):
        goal = Goal(action, time.monotonic())
        self.next += 1
        self.numbers[action, self.next] = ("goal", goal)
        self.goals[goal.id] = goal
        self.tell("goal", action, goal.id, *values)
        return goal

    def answer(self, goal, seconds=LONG):
        """True: accepted, False: refused, None: no answer in time."""
        self.until(lambda: goal.accepted is not None, seconds)
        return goal.accepted

    def result(self, goal, seconds=LONG):
        if not goal.asked_result:
            goal.asked_result = True
            self.next += 1
            self.numbers[goal.action, self.next] = ("result", goal)
            self.tell("result", goal.action, goal.id)
        self.until(lambda: goal.result is not None, seconds)
        return goal.status, goal.report

    def cancel(self, action, goal=None):
        """Of one goal, else of all of the action. The return code and the goals that are cancelled."""
        self.next += 1
        number = self.next
        self.tell("cancel", action, goal.id if goal else "all")
        self.until(lambda: number in self.cancels)
        event = self.cancels.get(number, {"code": None, "goals": []})
        return event["code"], [row[0] for row in event["goals"]]

    def again(self, action):
        """After a bridge died: until a new one answers. What is sent before both sides have found each other is lost, as any volatile sample."""
        for _ in range(30):
            self.next += 1
            number = self.next
            self.tell("cancel", action, uuid.uuid4().hex)
            if self.until(lambda number=number: number in self.cancels, 1):
                return True
        return False

    def goal_of_new_bridge(self, action, *values):
        """The first goal that is answered: each service finds the new bridge by itself, and what is sent before is lost."""
        goal = None
        for _ in range(15):
            goal = self.goal(action, *values)
            if self.answer(goal, 3) is not None:
                break
        return goal

    def hashes(self):
        self.ends = []
        self.tell("hashes")
        while (self.hear(10) or {"event": "hashes"})["event"] != "hashes":
            pass
        return self.ends
