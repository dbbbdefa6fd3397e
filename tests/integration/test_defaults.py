"""One configuration for every task."""

from harness import ACTOR, LEARNER


def output_of(stage, *command):
    process = stage.start(*command)
    assert process.wait(60) == 0, process
    return [line.strip() for line in process.output]


def test_the_defaults_of_all_fifty_tasks_differ_in_the_task_alone(stage):
    tasks = [line.split()[0] for line in output_of(stage, ACTOR, "tasks")[1:]]
    assert len(tasks) == 50
    configurations = set()
    for task in tasks:
        lines = output_of(stage, LEARNER, "config", "--task", task)
        named = [line for line in lines if f'"{task}"' in line or f'"metaworld/{task}"' in line]
        assert len(named) == 3, named  # task, spec.name, spec.short_name
        configurations.add(tuple(line for line in lines if line not in named))
    assert len(configurations) == 1
