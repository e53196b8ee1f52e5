function field = holo_read(folder)
%HOLO_READ  Read a folder that `holo render` or `holo dataset` wrote.
%
%   FIELD = HOLO_READ(FOLDER) returns a structure with the fields
%
%     H          light field, [V U T S C], in the integers of the files:
%                squeeze(H(i,j,:,:,:)) is an elemental image and
%                squeeze(H(:,:,k,l,:)) a viewpoint image, both upright.
%                From scene_5d.mat, else scene_el.png, else scene_vpi.png;
%                [] if there is none of them.
%     rig        views [T S], lenses [V U], baseline_m [y x],
%                focal_length_mm, sensor_size_mm, focus_distance_m (may be
%                Inf) and projection.
%     depth      depth of the central view along the optical axis, [V U],
%                m; Inf where nothing was hit. [] without scene_depth.pfm.
%     disparity  disparity of the central view, [V U], px between adjacent
%                views, positive nearer than the focus plane. [] without
%                scene_disparity.pfm.
%
%   The central view is row floor(T/2)+1, column floor(S/2)+1 of the views.
%   Runs in MATLAB R2016b or later and in GNU Octave 7 or later. Octave
%   does not read a scene_5d.mat of version 7.3 (beyond 2 GiB); the PNGs
%   take its place.

  name = fullfile(folder, 'manifest.json');
  if exist(name, 'file') ~= 2
    error('holo_read:folder', '%s: no manifest.json; give a folder that holo rendered', folder);
  end
  manifest = jsondecode(fileread(name));
  field.rig = read_rig(manifest.rig);
  field.H = read_light_field(folder, field.rig);
  field.depth = read_pfm(fullfile(folder, 'scene_depth.pfm'));
  field.disparity = read_pfm(fullfile(folder, 'scene_disparity.pfm'));
end

function rig = read_rig(json)
% Rows first, as everywhere in arrays; the manifest names columns and rows.
  rig.views = [json.views.rows, json.views.columns];
  rig.lenses = [json.lenses.rows, json.lenses.columns];
  rig.baseline_m = [json.baseline_m.y, json.baseline_m.x];
  rig.focal_length_mm = json.focal_length_mm;
  rig.sensor_size_mm = json.sensor_size_mm;
  rig.focus_distance_m = json.focus_distance_m;
  if ischar(rig.focus_distance_m)
    rig.focus_distance_m = str2double(rig.focus_distance_m);
  end
  rig.projection = json.projection;
end

function H = read_light_field(folder, rig)
  H = [];
  name = fullfile(folder, 'scene_5d.mat');
  if exist(name, 'file') == 2 && ~is_unreadable_in_octave(name)
    file = load(name);
    if isfield(file, 'H')
      H = file.H;
    else
      H = permute(file.LF, [3 4 1 2 5]);
    end
    return
  end
  T = rig.views(1); S = rig.views(2); V = rig.lenses(1); U = rig.lenses(2);
  name = fullfile(folder, 'scene_el.png');
  if exist(name, 'file') == 2
    % Row v*T+t, column u*S+s: the inner index runs fastest.
    image = imread(name);
    H = permute(reshape(image, [T V S U size(image, 3)]), [2 4 1 3 5]);
    return
  end
  name = fullfile(folder, 'scene_vpi.png');
  if exist(name, 'file') == 2
    image = imread(name);
    H = permute(reshape(image, [V T U S size(image, 3)]), [1 3 2 4 5]);
  end
end

function answer = is_unreadable_in_octave(name)
% Octave reads HDF5 files of its own kind only. Version 7.3 names itself in its first bytes.
  answer = false;
  if exist('OCTAVE_VERSION', 'builtin')
    file = fopen(name, 'r');
    head = fread(file, [1 10], 'uint8=>char');
    fclose(file);
    answer = strcmp(head, 'MATLAB 7.3');
  end
end

function map = read_pfm(name)
  map = [];
  if exist(name, 'file') ~= 2
    return
  end
  file = fopen(name, 'r');
  closes = onCleanup(@() fclose(file));
  if ~strcmp(fgetl(file), 'Pf')
    error('holo_read:pfm', '%s: not a gray PFM', name);
  end
  counts = sscanf(fgetl(file), '%d');
  % A negative scale stands for little-endian numbers.
  if sscanf(fgetl(file), '%f') < 0
    order = 'ieee-le';
  else
    order = 'ieee-be';
  end
  [map, count] = fread(file, counts', 'single=>single', 0, order);
  if count < prod(counts)
    error('holo_read:pfm', '%s: the file ends early', name);
  end
  % Rows are stored from the bottom up.
  map = flipud(map');
end
