"""M70 … M73: an NGC program keeps its modal state, and goes back to it, as in LinuxCNC.

    saved = SavedModes(modes)
    saved.carry_out(700)        # M70 keeps; M71 forgets, M72 goes back, M73 keeps until the subroutine returns
    saved.enter_call(); saved.leave_call()        # around each call: a subroutine has a state of its own

Kept are units, plane, G90 and G90.1, feed mode, F, work offsets, tool length, G98, S, M3 to M5, M7 to M9. The motion that holds (G1) is not.
The lines that go back are plain G-code: nothing is kept on the board. G40 comes back, G41 and G42 do not.
"""

from host_tools.language import _
from host_tools.programs.program_errors import NOT_KEPT, NOT_ON_BOARD, ProgramError

SAVE, FORGET, RESTORE, SAVE_FOR_CALL = 700, 710, 720, 730
_FIELDS = ("scale", "plane", "absolute", "arc_absolute", "feed_mode", "feed", "typed", "initial")


class SavedModes:
    def __init__(self, modes):
        self._modes = modes
        self._levels = [(None, False)]  # of each call (state, or None; True if it is gone back to at the call's end)

    def carry_out(self, code):
        """Carry out M70 to M73. Raises ProgramError if no state is kept."""
        if code == RESTORE:
            state = self._levels[-1][0]
            if state is None:
                raise ProgramError(NOT_KEPT)
            self._restore_state(state)
        else:
            self._levels[-1] = None if code == FORGET else self._modal_state(), code == SAVE_FOR_CALL

    def enter_call(self):
        self._levels.append((None, False))

    def leave_call(self):
        """Leave a subroutine; restore the state if M73 kept it. Raises ProgramError."""
        state, at_end = self._levels.pop()
        if at_end:
            self._restore_state(state)

    def _modal_state(self):
        modes = self._modes
        fields = {name: getattr(modes, name) for name in _FIELDS}
        return fields, bool(modes.path.contour), modes.system, modes.length, (modes.rpm, modes.spindle), modes.coolant

    def _restore_state(self, state):
        """Go back to the state of _modal_state(), and append the words for it. Raises ProgramError if compensation would begin again, or the tool's
        length was not the program's."""
        modes, path = self._modes, self._modes.path
        fields, compensated, system, length, turning, coolant = state
        if path.contour and not compensated:
            path.uncompensate()
        elif compensated and not path.contour:
            raise ProgramError(NOT_ON_BOARD, "M72: {}", _("G41 and G42 do not come back"))
        for name, value in fields.items():
            setattr(modes, name, value)
        if system != modes.system:
            modes.set_system(system + 53)
        if length != modes.length:
            if length[1] is None:
                raise ProgramError(NOT_ON_BOARD, "M72: {}", _("a tool length that the program had not set"))
            modes.set_tool_length(*length)
        if turning != (modes.rpm, modes.spindle):
            modes.turn_spindle(*turning)
        if coolant != modes.coolant:
            modes.coolant = coolant
            path.put_word("M9")
            for word in sorted(coolant):
                path.put_word(word)
