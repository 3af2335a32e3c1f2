"""Inquiries: what several need is done once, each goes on as soon as it can, losses stay local."""

import pytest

from comparisons.errors import ResultsError
from comparisons.solving.inquiries import Inquiries, answer_of, curves, together
from comparisons.solving.jobs import Archive, Job, JobKind
from comparisons.solving.planning import plan_scene

CALLS: list[int] = []


def square(number):
    CALLS.append(number)
    return number**2


def number_in(path):
    try:
        return int(path.read_text())
    except ValueError as error:
        raise ResultsError(str(error)) from error


TEXT = Archive(
    ".txt", lambda path, value: path.write_text(str(value)), number_in, lambda value: value < 100
)


def job(number):
    return Job(
        f"square-{number}", square, (number,), kind=JobKind("squares", "square"), archive=TEXT
    )


def squares(*numbers):
    """Ask for one square after the other, and return their sum."""
    total = 0
    for number in numbers:
        done = yield [job(number)]
        total += done[f"square-{number}"].value
    return total


@pytest.fixture(autouse=True)
def fresh():
    CALLS.clear()


def asked(inquiries, **named):
    list(inquiries.ask(named))
    return inquiries.answers


def test_what_two_inquiries_need_is_done_once():
    """At the same time (3) or long after the other has had it (2)."""
    assert asked(Inquiries(), one=squares(3, 2), two=squares(3, 4, 2)) == {"one": 13, "two": 29}
    assert sorted(CALLS) == [2, 3, 4]


def test_counts_grow_with_what_is_asked_and_the_rest_is_known_by_like_jobs():
    inquiries = Inquiries()
    under_way = inquiries.ask({"one": squares(1, 2), "two": squares(3)})
    told = [(inquiries.counts, inquiries.remaining().complete) for _ in under_way]
    assert told == [((0, 2), False), ((1, 3), True), ((2, 3), True), ((3, 3), True)]


def test_inquiries_in_step_answer_in_order_whoever_is_done_first():
    assert answer_of(together([squares(1, 2, 3), squares(), squares(4)])) == [14, 0, 16]


def test_a_folder_answers_again_unless_it_is_torn_not_final_or_a_run_anew(tmp_path):
    asked(Inquiries(folder=tmp_path), all=squares(1, 2, 20))
    (tmp_path / "square-2.txt").write_text("torn")
    CALLS.clear()
    assert asked(Inquiries(folder=tmp_path, resume=True), all=squares(1, 2, 20)) == {"all": 405}
    assert CALLS == [2, 20]  # 400 is not final
    CALLS.clear()
    asked(Inquiries(folder=tmp_path), all=squares(1))
    assert CALLS == [1]


def test_what_this_run_found_is_not_tried_again_even_if_it_is_not_final(tmp_path):
    assert asked(Inquiries(folder=tmp_path), one=squares(20), two=squares(1, 20)) == {
        "one": 400,
        "two": 401,
    }
    assert CALLS == [20, 1]


def test_curves_come_without_the_solves_that_are_known(scene):
    (plan,) = plan_scene(scene(compare={"methods": ["closed_form", "reduced"]}))
    solved = answer_of(curves(plan))
    assert not any(solution.fields for solution in solved.values())
    known = {key: solved[key] for key in solved if key[0] == "reduced"}
    again = answer_of(curves(plan, known))
    assert set(again) == set(solved)
    assert all(again[key] is known[key] for key in known)
