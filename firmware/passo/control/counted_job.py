"""What the journal and the feature that plays a job by commands or points tell each other of it: see job_journal.py."""


class CountedJob:
    def __init__(self):
        self.kept = False  # the position has been counted without a break since a job was announced
        self.counting = False  # what is queued is of the job that the journal knows
        self.announced = False  # a job is to begin
        self.counted = 0  # points of it before those that are drawn
        self.progress = None  # progress(spot) puts into an array where the job is; None: blocks tell it
