"""The journal and the feature that plays a job by commands or points share these fields: see job_journal.py."""


class CountedJob:
    def __init__(self):
        self.kept = False  # the position has been counted without a break since a job was announced
        self.counting = False  # commands queued now are of the job that the journal knows
        self.announced = False  # a job is to begin
        self.counted = 0  # points of it before those that are drawn
        self.progress = None  # progress(spot) puts into an array where the job is; None: blocks tell it
