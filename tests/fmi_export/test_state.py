"""Saving, restoring and serialising the state of a running FMU."""


def test_a_saved_state_continues_as_the_first_run_did(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        def run(fmu: Fmu) -> list:
            rows = []
            for n in range(3, 8):
                fmu.set(u=n / 2.0)
                rows.append([fmu.step(n), *fmu.outputs()])
            return rows

        fmu, other = Fmu(path), Fmu(path)
        fmu.set(u=1.0)
        for n in range(3):
            fmu.step(n)
        saved = fmu.fmi.getFMUState()
        text = fmu.fmi.serializeFMUState(saved)
        outputs = fmu.outputs()
        runs = [run(fmu)]
        fmu.fmi.setFMUState(saved)
        assert fmu.outputs() == outputs
        runs.append(run(fmu))
        restored = other.fmi.deSerializeFMUstate(text)
        other.fmi.setFMUState(restored)
        assert other.outputs() == outputs
        runs.append(run(other))
        fmu.fmi.freeFMUState(saved)
        other.fmi.freeFMUState(restored)
        fmu.close()
        other.close()
        return runs

    first, again, elsewhere = run_python(host, path=build_fmu(lag))
    assert first == again == elsewhere
    assert first[0] != first[-1]


def test_a_saved_state_brings_back_a_run_from_before_its_fault(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path)
        saved = fmu.fmi.getFMUState()
        fmu.set(u=5.0)
        answer = [fmu.step(0)]
        fmu.fmi.setFMUState(saved)
        fmu.set(u=4.0)
        answer += [fmu.step(0), *fmu.get("fault_code")]
        fmu.close()
        return answer

    assert run_python(host, path=build_fmu(lag)) == [3, 0, 0]
