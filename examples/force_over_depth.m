% SPDX-License-Identifier: MIT
% Reads a run in MATLAB or Octave and draws the force on the tool over its depth.
%
%   palpate run fixtures/scenes/epidural.toml
%   >> addpath examples; force_over_depth('palpate-out/run')
%
% The columns are those of trace.csv (docs/formats.md). In MATLAB h5read('trace.h5', '/trace/tool.force_n')
% reads the same numbers; Octave has no h5read of its own.
function force_over_depth(run)
  summary = jsondecode(fileread(fullfile(run, 'summary.json')));
  file = fopen(fullfile(run, 'trace.csv'));
  names = strsplit(fgetl(file), ',');
  is_text = ismember(names, {'tool.layer', 'tool.event'});
  formats = repmat({'%f'}, size(names));
  formats(is_text) = {'%q'};
  columns = textscan(file, strjoin(formats, ''), 'Delimiter', ',');
  fclose(file);
  column = @(name) columns{strcmp(names, name)};

  time = column('time_s');
  depth = 1e3 * column('tool.depth_m');
  force = column('tool.force_n');
  [peak, row] = max(force);
  fprintf('peak force %.6g N at %.6g mm, t = %.6g s; summary.json says %.6g N\n', ...
          peak, depth(row), time(row), summary.peak_force_n);

  if isempty(getenv('DISPLAY')) && exist('OCTAVE_VERSION', 'builtin')
    return  % no screen to draw on
  end
  plot(depth, force);
  xlabel('depth (mm)');
  ylabel('force on the tool (N)');
end
