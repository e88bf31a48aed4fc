"""The bytes free on a memory card: under CPython and MicroPython."""

from check_jobs import Flash


def check_free_card():
    from passo.options.card.config import CardStore
    from passo.options.jobs import config as job_store

    before = job_store.os
    try:
        job_store.os = Flash(100)
        assert CardStore("/sd/jobs").free_bytes() == 100 * 4096
    finally:
        job_store.os = before
