"""A little of fuzz_grbl.py; `make bench ARGS=fuzz` has a million lines."""

from fuzz_grbl import Fuzz

CASES = {"check_fuzz": (("seed", "seed"),), "check_lines_of_an_axis_that_is_too_slow_for_a_step": (("seed", "seed"),)}
RUNS = {"check_fuzz": 12, "check_lines_of_an_axis_that_is_too_slow_for_a_step": 2}


def check_fuzz(seed):
    Fuzz(seed).run(60)


def check_lines_of_an_axis_that_is_too_slow_for_a_step(seed):
    """If an axis may take more than 40 s for a step, its lines are refused, those of other axes move, and the main loop goes on."""
    fuzz = Fuzz(seed)
    for count in range(1, 9):
        assert fuzz._answers(b"$111=0.01\n", 1) and fuzz._settle()
        before = list(fuzz.controller.queue.target)
        answers = [fuzz._turn(b"G91G1F600\n" if count == 1 else b"")]
        fuzz.port.incoming += b"Y1\nX1\n" * count
        while sum([number for number, _ in answers]) < 2 * count + (count == 1):
            answers.append(fuzz._turn())
        assert fuzz._settle() and list(fuzz.controller.queue.target) == [before[0] + 2 * count, before[1], before[2]]
        fuzz.controller.queue.set_origin()
