"""Figures of an agent's machines for Prometheus: OpenMetrics over HTTP.

    figures = Figures()
    figures.watch("plotter-3", state_topics)
    close = figures.serve("127.0.0.1", 9464)        # http://127.0.0.1:9464/metrics
    close()
"""

from prometheus_client import CollectorRegistry, start_http_server
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.registry import Collector

from host_tools.failure import Failure, reason
from host_tools.shop.state_topics import LOST

# Counters of a StateTopics: (figure, help, label or None, {label's value: counter}).
_COUNTERS = (
    ("passo_jobs", "Jobs that have ended.", "how", {"done": "jobs", "failed": "failed"}),
    ("passo_alarms", "Alarms.", None, {"": "alarms"}),
    ("passo_refused", "Commands that the board has refused, and errors that it has noted.", None, {"": "refused"}),
    ("passo_stops", "Stops that came by the broker.", None, {"": "stops"}),
    ("passo_motion_seconds", "Time in motion.", None, {"": "run_s"}),
    ("passo_way_metres", "Way from report to report.", None, {"": "metres"}),
    ("passo_steps", "Steps of all axes, from report to report.", None, {"": "steps"}),
    ("passo_late_words", "Times that the board's steps were not computed in time, and the motion paused.", None, {"": "late"}),
    ("passo_retries", "Questions and packets that the board has not answered and that were said again; connections to the broker that were lost and begun anew.", "to", {"board": "retries", "broker": "connections"}),
)
# Gauges: (figure, help, topic of a StateTopics, factor).
_GAUGES = (
    ("passo_job_progress_ratio", "How much of the job is done.", "progress", 0.01),
    ("passo_job_left_seconds", "Time left of the job.", "left", 1.0),
    ("passo_queue_ratio", "How full the board's queue of blocks is.", "full", 0.01),
)


class Figures(Collector):
    def __init__(self):
        self._machines = {}

    def watch_machine(self, name, state_topics):
        self._machines[name] = state_topics

    def collect(self):
        """Yield the metrics of all machines, as prometheus_client wants them."""
        machines = [(name, state_topics) for name, state_topics in self._machines.items() if state_topics.told]
        up = GaugeMetricFamily("passo_up", "1: the board answers.", labels=["machine"])
        state = GaugeMetricFamily("passo_state", "1 for the machine's state.", labels=["machine", "state"])
        for name, state_topics in machines:
            up.add_metric([name], float(state_topics.told["state"] != LOST))
            state.add_metric([name, state_topics.told["state"]], 1.0)
        yield up
        yield state
        for figure, text, topic, factor in _GAUGES:
            family = GaugeMetricFamily(figure, text, labels=["machine"])
            for name, state_topics in machines:
                value = {**state_topics.told, "full": state_topics.full}[topic]
                if value not in ("", None):
                    family.add_metric([name], float(value) * factor)
            yield family
        for figure, text, label, values in _COUNTERS:
            counted = CounterMetricFamily(figure, text, labels=["machine", label] if label else ["machine"])
            for name, state_topics in machines:
                for value, counter in values.items():
                    counted.add_metric([name, value] if label else [name], state_topics.counters[counter])
            yield counted

    def serve(self, host, port):
        """Serve the figures over HTTP from a thread; returns the function that ends it. Raises Failure if the port is in use."""
        registry = CollectorRegistry()
        registry.register(self)
        try:
            server, thread = start_http_server(port, host, registry)
        except OSError as error:
            raise Failure("--figures {}:{}: {}", host, port, reason(error)) from error

        def close():
            server.shutdown()
            server.server_close()
            thread.join()

        return close
