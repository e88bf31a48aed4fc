"""The topics of a machine's state, made of the values that its page shows (passo/protocols/page).

    state_topics = StateTopics()
    state_topics.look(machine.shown(), now_s)    # {topic: text} of all topics, see TOPICS
    state_topics.events(now_s)                   # [{"what": "begun", …}] since the last time

A topic is text, JSON if it has several values, "" if it has none.
"""

import json

from host_tools.language import error_text
from passo import errors

TOPICS = ("state", "job", "progress", "left", "place", "alarm", "counters")
GONE = "gone"  # state: nobody speaks for the machine any more, the broker says so
LOST = "lost"  # state: the board does not answer
_MOVES = ("run", "jog", "home")
_OFTEN = ("place", "counters", "left")  # change with each report of a machine that moves: published
_OFTEN_S = 1.0  # at most once in this time
_SURE = 2  # per cent of a job from which on the time left is published


class StateTopics:
    def __init__(self):
        self._events = []
        self._state = ""
        self._alarm = 0
        self._job = None  # (name, when it has begun)
        self._place = None
        self.scale = ()  # steps/mm of each axis; (): not known yet
        self._late = None  # how often steps were late since the board's start, as it said last
        self._then_s = self._often_s = None
        self.counters = {"jobs": 0, "failed": 0, "alarms": 0, "refused": 0, "stops": 0, "run_s": 0.0, "metres": 0.0, "steps": 0, "late": 0, "retries": 0, "connections": 0}
        self.told = {}  # the last result of look()
        self.full = None  # per cent of the board's queue that is in use, if it tells

    def look(self, shown, now_s):
        """Return {topic: text} of all topics, see TOPICS, and note events. `shown`: the state for pages; `now_s`: a monotonic clock."""
        state = shown["state"].lower() if shown["link"] and shown["state"] else LOST
        self._count_motion(shown, state, now_s)
        name, share = self._job_of(shown)
        self._follow_job(name, shown, now_s)
        alarm = shown["alarm"]
        if alarm and alarm != self._alarm:
            self.counters["alarms"] += 1
            self._add_event("alarm", number=alarm, text=error_text(alarm))
        self._alarm = alarm
        if state != self._state:
            self._add_event("state", before=self._state, state=state)
            self._state = state
        left = "" if share is None or share < _SURE or not self._job else round((now_s - self._job[1]) * (100 - share) / share)
        self.full = shown.get("full")
        told = {
            "state": state,
            "job": name,
            "progress": "" if share is None else str(share),
            "left": str(left),
            "place": json.dumps(shown["w"]) if shown.get("w") else "",
            "alarm": error_text(alarm or errors.LOCKED) if alarm or state == "alarm" else "",
            "counters": json.dumps({key: round(value, 3) for key, value in self.counters.items()}),
        }
        if state in _MOVES and self._often_s is not None and now_s - self._often_s < _OFTEN_S:
            told |= {key: self.told[key] for key in _OFTEN}
        else:
            self._often_s = now_s
        self.told = told
        return told

    def events(self, now_s):
        """[{"at", "what", …}] since the last call; `at`: seconds since 1970."""
        found, self._events = self._events, []
        return [{"at": round(now_s, 3), **event} for event in found]

    def count_stop(self):
        """Count a STOP that came from the broker."""
        self.counters["stops"] += 1
        self._add_event("stop")

    def count_refusal(self, number):
        """Count an order that the board refused, or an error of its log."""
        self.counters["refused"] += 1
        self._add_event("refused", number=number, text=error_text(number))

    def note_late(self, count):
        """Add to the counters how many words of steps came late since the last call. `count`: those since the board's start; if it is lower than
        last time, the board has begun anew."""
        if self._late is not None:
            self.counters["late"] += count - self._late if count >= self._late else count
        self._late = count

    def _add_event(self, what, **more):
        """Add an event to the machine's log."""
        self._events.append({"what": what, **more})

    @staticmethod
    def _job_of(shown):
        """(name, per cent) of the job that runs; ("", None): none. The board reports a job that it stores as `PER CENT,NAME`."""
        job, stored = shown.get("job"), shown.get("stored") or ""
        if job and job["how"] in ("run", "halting"):
            return job["name"], 100 * job["done"] // max(job["lines"], 1)
        share, comma, name = stored.partition(",")
        return (name.rstrip("?"), int(share)) if comma and share.isdigit() else ("", None)

    def _follow_job(self, name, shown, now_s):
        """Add an event for the beginning and the end of a job, and count jobs."""
        if self._job and self._job[0] != name:
            job = shown.get("job")
            failed = shown["alarm"] or bool(job and job["name"] == self._job[0] and job["how"] == "failed")
            self.counters["failed" if failed else "jobs"] += 1
            self._add_event("failed" if failed else "done", job=self._job[0], seconds=round(now_s - self._job[1], 1))
            self._job = None
        if name and not self._job:
            self._job = name, now_s
            self._add_event("begun", job=name)

    def _count_motion(self, shown, state, now_s):
        """Count time in motion (s), the way of X, Y and Z (m) and all axes' steps, along a straight line from each report to the next."""
        place = shown.get("m")
        if self._then_s is not None and state in _MOVES:
            self.counters["run_s"] += now_s - self._then_s
        if place and self._place and len(place) == len(self._place) and state not in (LOST, "home"):
            self.counters["metres"] += sum((to - at) ** 2 for to, at in zip(place[:3], self._place[:3])) ** 0.5 / 1000
            self.counters["steps"] += sum(round(abs(to - at) * scale) for to, at, scale in zip(place, self._place, self.scale))
        self._place, self._then_s = place, now_s
