; The disk alone in Csound, sample by sample. tools/bench/programs.py puts in the numbers in
; braces; friction.txt has the table's points.
<CsoundSynthesizer>
<CsOptions>
-n -d -m0
</CsOptions>
<CsInstruments>
sr = 48000
ksmps = 1
nchnls = 1
0dbfs = 1
giFriction ftgen 1, 0, -65537, -23, "friction.txt"
instr 1
  iDt = 1 / sr
  iInertia = {inertia}
  iK1 = {k1}
  iK2 = {k2}
  iK = iK1 + iK2
  iCells = 65536 * iK / iK2 / 3.141592653589793
  kTheta init 0
  kOmega init 0
  kTime init 0.5 / sr
  kCell limit (kTheta + 0.5 * iDt * kOmega) * iCells, 0, 65535.999
  kB tablei kCell, 1
  kMean = (2 * iInertia * kOmega + iDt * (iK2 * kTime * {speed} - iK * kTheta)) / \
          (2 * iInertia + iDt * kB + 0.5 * iDt * iDt * iK)
  kTheta = kTheta + iDt * kMean
  kOmega = 2 * kMean - kOmega
  kTime = kTime + iDt
  out a(kB * kMean)
endin
</CsInstruments>
<CsScore>
i 1 0 {seconds}
</CsScore>
</CsoundSynthesizer>
