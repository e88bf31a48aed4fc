"""The meanings of the numbers of errors.py beside it: see passo/error_texts.py."""

from passo.options.jobs.errors import (
    ALARM_JOB_CHANGED, JOB_DAMAGED, JOB_LANGUAGE, JOB_MEMORY, JOB_RUNS, JOB_SPACE, JOB_STOPPED, JOB_UPLOAD, NO_CARD, NO_JOB, STORED_NAME,
)  # fmt: skip

TEXTS = {
    NO_JOB: "there is no stored job of that name: passo jobs list shows them",
    JOB_DAMAGED: "the stored job is damaged or was not sent whole: store it again",
    JOB_SPACE: "the memory is full or broken: delete stored jobs; those that were there are kept",
    JOB_RUNS: "a stored job is running: stop it first",
    STORED_NAME: "a job's name has at most 24 capitals, digits, '.', '_' and '-'",
    JOB_LANGUAGE: "the job is of another language than the board file's jobs.language",
    JOB_UPLOAD: "no upload is under way, or it has not as many bytes as were announced",
    JOB_STOPPED: "the stored job was stopped before its end",
    NO_CARD: "no memory card answers: is it in, formatted with FAT, and is the driver sdcard on the board?",
    JOB_MEMORY: "no memory is left to read the job with: reset the board, or take a link out of its board file",
    ALARM_JOB_CHANGED: "the stored job is not the same as before it began: the memory it lies in is damaged; store the job again",
}
