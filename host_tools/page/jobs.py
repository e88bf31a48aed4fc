"""Pages of machines on cables to which the PC sends jobs.

    class PlotterMachine(with_jobs(on_cable(PlotterPage))): …     # sets `job`
"""

from passo import errors


def with_jobs(kind):
    """The class of pages `kind`, see cable_page.py, with a job: is_running(), run(), play(), poll(), refresh_state(), abort(), fail(error)."""

    class WithJobs(kind):
        job = None

        def feed(self, data, now_ms):
            kind.feed(self, data, now_ms)
            self.job.poll()

        def poll(self, now_ms):
            kind.poll(self, now_ms)
            self.job.poll()

        def raise_alarm(self, number):
            kind.raise_alarm(self, number)
            self.job.fail(number)

        def note_silence(self):
            kind.note_silence(self)
            self.job.fail(errors.NO_ANSWER)

        def page_state(self):
            self.job.refresh_state()
            return kind.page_state(self)

        def busy_error(self):
            return errors.BUSY if self.job.is_running() else kind.busy_error(self)

        def _may_jog(self, direction):
            return kind._may_jog(self, direction) and not self.job.is_running()

        def run(self, name, lines, passes, checked, single):
            return self.job.run(name, lines, passes, checked, single)

        def play(self, what):
            return self.job.play(what)

        def abort(self):
            return self.job.abort()

        def stop(self):
            self.job.fail(errors.STOPPED)
            return kind.stop(self)

    return WithJobs
